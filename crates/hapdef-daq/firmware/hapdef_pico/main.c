/* A Raspberry Pi Pico (RP2040) with a converter, as HDP1 over USB. docs/board.md has the wiring and
 * how to build and flash; with_*.c has gain, rate and channels. */
#include <string.h>

#include "hardware/gpio.h"
#include "hardware/spi.h"
#include "pico/rand.h"
#include "pico/stdlib.h"
#include "pico/unique_id.h"
#include "tusb.h"

#include "pico_board.h"

enum { MISO = 16, CS = 17, SCLK = 18, MOSI = 19, DRDY = 20, RESET = 21, HX711_SCK = 2, HX711_DOUT = 3 };

static struct board board;

static uint32_t now_us(void *context)
{
    (void)context;
    return time_us_32();
}

static void delay_us(void *context, uint32_t us)
{
    (void)context;
    busy_wait_us_32(us);
}

static uint pin_of(unsigned pin)
{
    switch (pin) {
    case ADC_CS: return CS;
    case ADC_RESET: return RESET;
    case ADC_DRDY: return DRDY;
    case ADC_SCK: return HX711_SCK;
    default: return HX711_DOUT + pin - ADC_DOUT;
    }
}

static void write_pin(void *context, unsigned pin, int level)
{
    (void)context;
    gpio_put(pin_of(pin), level != 0);
}

static int read_pin(void *context, unsigned pin)
{
    (void)context;
    return gpio_get(pin_of(pin));
}

static void exchange(void *context, const uint8_t *out, uint8_t *in, size_t n)
{
    (void)context;
    spi_write_read_blocking(spi0, out, in, n);
}

/* DTR. What TinyUSB still holds when a host goes is old for the next one. */
static int is_open(void *context)
{
    (void)context;
    if (tud_cdc_connected())
        return 1;
    tud_cdc_write_clear();
    return 0;
}

static size_t room(void *context)
{
    (void)context;
    return tud_cdc_write_available();
}

static size_t write_port(void *context, const uint8_t *bytes, size_t n)
{
    size_t taken = tud_cdc_write(bytes, (uint32_t)n);

    (void)context;
    tud_cdc_write_flush();
    return taken;
}

static int read_port(void *context)
{
    (void)context;
    return tud_cdc_available() ? (int)tud_cdc_read_char() : -1;
}

static void output(uint pin, bool level)
{
    gpio_init(pin);
    gpio_put(pin, level);
    gpio_set_dir(pin, GPIO_OUT);
}

/* An input that is high if nothing drives it: a converter that is not there is never ready. */
static void input(uint pin)
{
    gpio_init(pin);
    gpio_set_dir(pin, GPIO_IN);
    gpio_pull_up(pin);
}

static void set_up_pins(void)
{
    unsigned i;

    if (converter_spi_hz > 0) {
        spi_init(spi0, converter_spi_hz);
        spi_set_format(spi0, 8, SPI_CPOL_0, SPI_CPHA_1, SPI_MSB_FIRST);
        gpio_set_function(MISO, GPIO_FUNC_SPI);
        gpio_set_function(SCLK, GPIO_FUNC_SPI);
        gpio_set_function(MOSI, GPIO_FUNC_SPI);
        output(CS, true);
        output(RESET, true);
        input(DRDY);
    } else {
        output(HX711_SCK, false);
        for (i = 0; i < converter_n_douts; i++)
            input(HX711_DOUT + i);
    }
}

int main(void)
{
    static const struct adc_io io = {0, exchange, write_pin, read_pin, delay_us, now_us};
    static const struct board_port port = {0, now_us, is_open, room, write_port, read_port};
    struct hdp1_hello hello;
    pico_unique_board_id_t id;
    struct adc adc;

    tusb_init();
    set_up_pins();
    memset(&hello, 0, sizeof hello);
    adc = converter(&io, &hello);
    pico_get_unique_board_id(&id);
    memcpy(hello.uid, id.id, sizeof id.id);
    hello.boot_id = get_rand_32();
    board_begin(&board, &port, &adc, &hello);
    for (;;) {
        tud_task();
        board_turn(&board);
    }
}
