/* A Pico on the bench: 5 s with the chip FAKE_CHIP behind the pins of docs/board.md, while FAKE_FAULT is
 * played. The host's bytes are on standard input, the board's on standard output. */
#include "sdk.h"

#include <stdio.h>
#include <stdlib.h>

#include "../fake/fake.h"

enum { N_PINS = 30, FIFO_LEN = 1024, MISO = 16, SCLK = 18, MOSI = 19 };
static const uint64_t RUN_NS = 5000000000u, CALL_NS = 60;

static struct {
    bool is_used, is_output, is_pulled_up;
    int function;
} pins[N_PINS];
static struct {
    uint32_t hz;
    int mode;
} spi;
static uint64_t fifo_ns;
static uint32_t fifo_len;

static void fail(const char *words)
{
    fprintf(stderr, "%s\n", words);
    exit(3);
}

/* docs/board.md: CS 17, DRDY 20, RESET 21; HX711: clock 2, data from 3 on. */
static unsigned fake_pin(uint pin)
{
    switch (pin) {
    case 17: return FAKE_CS;
    case 20: return FAKE_DRDY;
    case 21: return FAKE_RESET;
    case 2: return FAKE_SCK;
    default: break;
    }
    if (pin < 3 || pin > 12)
        fail("a pin that is not wired");
    return FAKE_DOUT + pin - 3;
}

void gpio_init(uint pin) { pins[pin].is_used = true; }
void gpio_set_dir(uint pin, bool is_output) { pins[pin].is_output = is_output; }
void gpio_pull_up(uint pin) { pins[pin].is_pulled_up = true; }
void gpio_set_function(uint pin, int function) { pins[pin].function = function; }

void gpio_put(uint pin, bool level)
{
    if (!pins[pin].is_used)
        fail("a pin before gpio_init");
    fake_write(fake_pin(pin), level);
}

bool gpio_get(uint pin)
{
    if (!pins[pin].is_used || pins[pin].is_output || !pins[pin].is_pulled_up)
        fail("a pin that is no input with a pull-up");
    return fake_read(fake_pin(pin)) != 0;
}

spi_inst_t *const spi0 = NULL;

uint spi_init(spi_inst_t *instance, uint hz)
{
    (void)instance;
    spi.hz = hz;
    return hz;
}

void spi_set_format(spi_inst_t *instance, uint bits, spi_cpol_t cpol, spi_cpha_t cpha,
                    spi_order_t order)
{
    (void)instance;
    if (bits != 8 || order != SPI_MSB_FIRST)
        fail("SPI's words");
    spi.mode = 2 * (int)cpol + (int)cpha;
}

int spi_write_read_blocking(spi_inst_t *instance, const uint8_t *out, uint8_t *in, size_t n)
{
    (void)instance;
    if (pins[MISO].function + pins[SCLK].function + pins[MOSI].function != 3 * GPIO_FUNC_SPI)
        fail("SPI's pins");
    fake_exchange(out, in, n, spi.hz, spi.mode);
    return (int)n;
}

uint32_t time_us_32(void)
{
    fake_spend(CALL_NS);
    return (uint32_t)(fake_ns / 1000);
}

void busy_wait_us_32(uint32_t us) { fake_spend(1000u * (uint64_t)us); }
uint32_t get_rand_32(void) { return 4711; }

void pico_get_unique_board_id(pico_unique_board_id_t *id)
{
    uint8_t i;

    for (i = 0; i < 8; i++)
        id->id[i] = (uint8_t)(0xa0 + i);
}

bool tusb_init(void)
{
    const char *chip = getenv("FAKE_CHIP"), *fault = getenv("FAKE_FAULT");

    if (!fake_begin(chip ? chip : "", fault ? fault : ""))
        fail("no such chip");
    return true;
}

/* USB carries a megabyte a second. */
void tud_task(void)
{
    uint64_t n;

    fake_spend(1000);
    n = (fake_ns - fifo_ns) / 1000;
    fifo_len -= n < fifo_len ? (uint32_t)n : fifo_len;
    fifo_ns += n * 1000;
    if (fake_ns >= RUN_NS)
        exit(0);
    /* The firmware is held up for longer than the converter keeps data. */
    if (fake_has_now("held up")) {
        static int n_turns;
        if (n_turns++ % 2000 == 0)
            fake_spend(3500000);
    }
}

bool tud_cdc_connected(void) { return !fake_has_now("closed"); }

/* A host that has gone without closing takes nothing. */
uint32_t tud_cdc_write_available(void)
{
    return fake_has_now("away") ? 0 : FIFO_LEN - fifo_len;
}

uint32_t tud_cdc_write(const void *bytes, uint32_t n)
{
    if (n > tud_cdc_write_available() || !tud_cdc_connected())
        fail("more than the port takes");
    fifo_len += n;
    return (uint32_t)fwrite(bytes, 1, n, stdout);
}

uint32_t tud_cdc_write_flush(void) { return 0; }

bool tud_cdc_write_clear(void)
{
    fifo_len = 0;
    return true;
}

uint32_t tud_cdc_available(void)
{
    int byte = getchar();

    if (byte == EOF)
        return 0;
    ungetc(byte, stdin);
    return 1;
}

int32_t tud_cdc_read_char(void) { return getchar(); }
