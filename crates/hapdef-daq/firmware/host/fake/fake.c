/* The bench; see fake.h. */
#include "fake.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A call of the firmware to a pin or a clock takes that long. */
static const uint64_t CALL_NS = 60;
/* No test is as long. */
static const uint64_t END_NS = 30000000000u;

uint64_t fake_ns;
static const struct fake_chip *chip;
static const char *played = "";

int fake_begin(const char *name, const char *fault)
{
    static const struct fake_chip *const chips[] = {&fake_ads131m08, &fake_ads1256, &fake_hx711};
    size_t i;

    for (i = 0; i < sizeof chips / sizeof *chips; i++)
        if (strcmp(chips[i]->name, name) == 0)
            chip = chips[i];
    played = fault;
    return chip != NULL;
}

int fake_has(const char *fault)
{
    return strcmp(played, fault) == 0;
}

int fake_has_now(const char *fault)
{
    return fake_has(fault) && fake_ns >= 2000000000u && fake_ns < 2200000000u;
}

void fake_spend(uint64_t ns)
{
    fake_ns += ns;
    if (fake_ns > END_NS) {
        fprintf(stderr, "the firmware waits for ever\n");
        exit(4);
    }
    chip->advance();
}

void fake_write(unsigned pin, int level)
{
    fake_spend(CALL_NS);
    chip->pin(pin, level);
}

int fake_read(unsigned pin)
{
    fake_spend(CALL_NS);
    return fake_has("absent") ? 1 : chip->level(pin);
}

void fake_exchange(const uint8_t *out, uint8_t *in, size_t n, uint32_t hz, int mode)
{
    size_t i;

    if (mode != 1)
        fake_forbidden("SPI mode %d", mode);
    if (hz > chip->max_hz)
        fake_forbidden("SCLK of %lu Hz", (unsigned long)hz);
    fake_spend(CALL_NS);
    for (i = 0; i < n; i++) {
        uint8_t answer = chip->exchange(out[i]);
        /* Nothing drives the line: it floats high. */
        in[i] = fake_has("absent") ? 0xff : answer;
        fake_spend(8000000000u / hz);
    }
}

double fake_strain_ue(unsigned channel, uint32_t n)
{
    double strain_ue = (double)((n * 37u + channel * 1013u) % 4001u) - 2000.0 + 0.25 * channel;

    if (fake_has_now("full") && (channel == 2 || channel == 3))
        return channel == 2 ? 1.0e6 : -1.0e6;
    return strain_ue;
}

int32_t fake_code(double fraction, double counts)
{
    double code = floor(fraction * counts + 0.5);

    return code >= 8388607.0 ? 8388607 : code <= -8388608.0 ? -8388608 : (int32_t)code;
}

void fake_tell(unsigned channel, double strain_ue, int32_t code)
{
    fprintf(stderr, "conversion %u %.9g %ld\n", channel, strain_ue, (long)code);
}

void fake_forbidden(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    fprintf(stderr, "the data sheet of %s forbids: ", chip->name);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, "\n");
    va_end(arguments);
    exit(3);
}
