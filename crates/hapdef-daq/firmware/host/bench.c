/* A driver with its fake alone: bench CHIP FAULT.
 *
 * Prints "begin WORDS MICROSECONDS", then "poll WORDS MICROSECONDS" for the first scan or error, "scan"
 * with its codes, and each exchange by SPI before as "spi OUT IN". */
#include <stdio.h>
#include <string.h>

#include "../ads1256.h"
#include "../ads131m08.h"
#include "../hx711.h"
#include "fake/fake.h"

static uint32_t spi_hz;

static void show(const uint8_t *bytes, size_t n)
{
    while (n--)
        printf("%02x", *bytes++);
}

static void exchange(void *context, const uint8_t *out, uint8_t *in, size_t n)
{
    (void)context;
    fake_exchange(out, in, n, fake_has("too fast") ? 2 * spi_hz : spi_hz, fake_has("mode 0") ? 0 : 1);
    printf("spi ");
    show(out, n);
    printf(" ");
    show(in, n);
    printf("\n");
}

/* enum adc_pin and enum fake_pin are in one order: chip select, reset, ready, clock, data. */
static void write_pin(void *context, unsigned pin, int level)
{
    (void)context;
    fake_write(pin, level);
}

static int read_pin(void *context, unsigned pin)
{
    (void)context;
    return fake_read(pin);
}

static void delay_us(void *context, uint32_t us)
{
    (void)context;
    /* An interrupt in the middle of a pulse. */
    fake_spend(1000u * (uint64_t)(fake_has("interrupt") && us == 1 ? 70 : us));
}

static uint32_t now_us(void *context)
{
    (void)context;
    fake_spend(60);
    return (uint32_t)(fake_ns / 1000);
}

static const struct adc_io io = {NULL, exchange, write_pin, read_pin, delay_us, now_us};
static struct ads131m08 ads131m08;
static struct ads1256 ads1256;
static struct hx711 hx711;

static struct adc choose(const char *chip)
{
    if (strcmp(chip, "ads131m08") == 0) {
        struct ads131m08_settings settings = {12, 5, 1, 0};
        settings.log2_osr = fake_has("settings") ? 14 : 12;
        settings.chops = (uint8_t)fake_has("chop");
        spi_hz = ADS131M08_SPI_MAX_HZ;
        ads131m08.io = io;
        ads131m08.settings = settings;
        return ads131m08_adc(&ads131m08);
    }
    if (strcmp(chip, "ads1256") == 0) {
        struct ads1256_settings settings = {2, {ADS1256_MUX(0, 1), ADS1256_MUX(2, 3)}, 6, 0, 1};
        settings.log2_gain = fake_has("settings") ? 7 : 6;
        settings.rate = ADS1256_1000;
        spi_hz = ADS1256_SPI_MAX_HZ;
        ads1256.io = io;
        ads1256.settings = settings;
        return ads1256_adc(&ads1256);
    } else {
        struct hx711_settings settings = {10, HX711_A_128, 80};
        settings.rate_hz = fake_has("settings") ? 40 : 80;
        settings.input = fake_has("gain 64") ? HX711_A_64 : HX711_A_128;
        hx711.io = io;
        hx711.settings = settings;
        return hx711_adc(&hx711);
    }
}

int main(int n_arguments, char **arguments)
{
    struct adc adc;
    struct adc_scan scan;
    enum adc_result result;
    uint64_t from_ns;
    unsigned i;

    if (n_arguments != 3 || !fake_begin(arguments[1], arguments[2]))
        return 2;
    adc = choose(arguments[1]);
    fake_spend(1000);
    from_ns = fake_ns;
    result = adc.begin(adc.chip);
    printf("begin %s %lu\n", adc_words(result), (unsigned long)((fake_ns - from_ns) / 1000));
    if (result != ADC_OK)
        return 0;
    from_ns = fake_ns;
    do {
        fake_spend(2000);
        result = adc.poll(adc.chip, &scan);
    } while (result == ADC_PENDING);
    printf("poll %s %lu\n", adc_words(result), (unsigned long)((fake_ns - from_ns) / 1000));
    if (result != ADC_SCAN)
        return 0;
    printf("scan");
    for (i = 0; i < ADC_MAX_CHANNELS; i++)
        printf(" %ld", (long)scan.code[i]);
    printf("\n");
    return 0;
}
