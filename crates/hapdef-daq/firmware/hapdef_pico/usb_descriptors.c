/* What the board says to USB: one serial port, named by the board's own number. */
#include <string.h>

#include "pico/unique_id.h"
#include "tusb.h"

enum { MAKER = 1, PRODUCT, SERIAL, N_STRINGS };
enum { NOTIFICATIONS = 0x81, FROM_HOST = 0x02, TO_HOST = 0x82, N_INTERFACES = 2 };
enum { TOTAL_LEN = TUD_CONFIG_DESC_LEN + TUD_CDC_DESC_LEN };

static const tusb_desc_device_t device = {
    .bLength = sizeof(tusb_desc_device_t),
    .bDescriptorType = TUSB_DESC_DEVICE,
    .bcdUSB = 0x0200,
    .bDeviceClass = TUSB_CLASS_MISC,
    .bDeviceSubClass = MISC_SUBCLASS_COMMON,
    .bDeviceProtocol = MISC_PROTOCOL_IAD,
    .bMaxPacketSize0 = CFG_TUD_ENDPOINT0_SIZE,
    /* Raspberry Pi, serial port of the Pico's SDK. */
    .idVendor = 0x2e8a,
    .idProduct = 0x000a,
    .bcdDevice = 0x0100,
    .iManufacturer = MAKER,
    .iProduct = PRODUCT,
    .iSerialNumber = SERIAL,
    .bNumConfigurations = 1
};

static const uint8_t configuration[TOTAL_LEN] = {
    TUD_CONFIG_DESCRIPTOR(1, N_INTERFACES, 0, TOTAL_LEN, 0, 100),
    TUD_CDC_DESCRIPTOR(0, 0, NOTIFICATIONS, 8, FROM_HOST, TO_HOST, 64)
};

const uint8_t *tud_descriptor_device_cb(void)
{
    return (const uint8_t *)&device;
}

const uint8_t *tud_descriptor_configuration_cb(uint8_t index)
{
    (void)index;
    return configuration;
}

static void text_of(uint8_t index, char *text, size_t capacity)
{
    if (index == SERIAL)
        pico_get_unique_board_id_string(text, (uint)capacity);
    else
        strcpy(text, index == MAKER ? "hapdef" : "Pico");
}

const uint16_t *tud_descriptor_string_cb(uint8_t index, uint16_t language)
{
    static uint16_t descriptor[32];
    char text[31];
    size_t n = 1, i;

    (void)language;
    if (index >= N_STRINGS)
        return NULL;
    descriptor[1] = 0x0409;
    if (index > 0) {
        text_of(index, text, sizeof text);
        n = strlen(text);
        for (i = 0; i < n; i++)
            descriptor[1 + i] = (uint8_t)text[i];
    }
    descriptor[0] = (uint16_t)(TUSB_DESC_STRING << 8 | (2 * n + 2));
    return descriptor;
}
