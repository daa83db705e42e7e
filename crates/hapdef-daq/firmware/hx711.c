/* HX711; see hx711.h. Times are those of Avia's data sheet, page 5. */
#include "hx711.h"

#include <string.h>

enum { N_BITS = 24 };
/* T3 and T4, a pulse's halves: 0.2 us at least, 1 us typical; high for 50 us at most, and for 60 us it
 * is the command to switch off. */
static const uint32_t HALF_US = 1, MAX_HIGH_US = 50, OFF_US = 100;
/* Settling behind a reset or another input: 400 ms at 10 Hz, 50 ms at 80 Hz. */
static const uint8_t N_UNSETTLED = 4;
static const uint32_t MAX_PERIODS = 6, REVIVE_US = 2000000;

float hx711_scale(const struct hx711_settings *settings, float gauge_factor)
{
    float gain = settings->input == HX711_A_128 ? 128.0f : settings->input == HX711_B_32 ? 32.0f
                                                                                         : 64.0f;

    /* The range is half the supply over the gain: 20 mV at 5 V and 128. */
    return adc_quarter_bridge(0.5f / gain, 8388608.0f, gauge_factor);
}

static uint32_t period_us(const struct hx711 *chips)
{
    return 1000000u / chips->settings.rate_hz;
}

static uint32_t all(const struct hx711 *chips)
{
    return ((uint32_t)1 << chips->settings.n_chips) - 1u;
}

/* A bit a chip: its data line is high. */
static uint32_t data(const struct hx711 *chips)
{
    uint32_t high = 0;
    unsigned i;

    for (i = 0; i < chips->settings.n_chips; i++)
        if (chips->io.read(chips->io.context, ADC_DOUT + i))
            high |= (uint32_t)1 << i;
    return high;
}

/* A pulse of the clock. Returns how long it was high, in microseconds. */
static uint32_t pulse(struct hx711 *chips, uint32_t *high)
{
    const struct adc_io *io = &chips->io;
    uint32_t from_us = io->now_us(io->context), us;

    io->write(io->context, ADC_SCK, 1);
    io->delay_us(io->context, HALF_US);
    *high = data(chips);
    io->write(io->context, ADC_SCK, 0);
    us = io->now_us(io->context) - from_us;
    io->delay_us(io->context, HALF_US);
    return us;
}

/* Clocks all chips' codes in. 0 if the clock was high for too long, so that they may be off. */
static int read_codes(struct hx711 *chips, uint32_t code[ADC_MAX_CHANNELS])
{
    uint32_t high = 0;
    unsigned bit, i;

    memset(code, 0, ADC_MAX_CHANNELS * sizeof *code);
    for (bit = 0; bit < chips->settings.input; bit++) {
        if (pulse(chips, &high) >= MAX_HIGH_US)
            return 0;
        for (i = 0; i < chips->settings.n_chips && bit < N_BITS; i++)
            code[i] = code[i] << 1 | (high >> i & 1u);
    }
    return 1;
}

enum adc_result hx711_begin(struct hx711 *chips, const struct adc_io *io,
                            const struct hx711_settings *settings)
{
    struct hx711 fresh = {*io, *settings, 0, 0, 0, 0, N_UNSETTLED, 0};

    if (settings->n_chips < 1 || settings->n_chips > ADC_MAX_CHANNELS ||
        settings->input < HX711_A_128 || settings->input > HX711_A_64 ||
        (settings->rate_hz != 10 && settings->rate_hz != 80))
        return ADC_BAD_SETTINGS;
    *chips = fresh;
    io->write(io->context, ADC_SCK, 1);
    io->delay_us(io->context, OFF_US);
    io->write(io->context, ADC_SCK, 0);
    chips->begun_us = chips->read_us = io->now_us(io->context);
    return ADC_OK;
}

/* Notes who did not answer: ready had data, and the line rose behind the pulses, as it has to. */
static void note_dead(struct hx711 *chips, uint32_t ready)
{
    chips->dead |= all(chips) & ~(ready & data(chips));
}

static void put(const struct hx711 *chips, const uint32_t code[ADC_MAX_CHANNELS],
                struct adc_scan *scan)
{
    unsigned i;

    memset(scan, 0, sizeof *scan);
    scan->faulty = chips->dead;
    for (i = 0; i < chips->settings.n_chips; i++) {
        uint8_t bytes[3] = {(uint8_t)(code[i] >> 16), (uint8_t)(code[i] >> 8), (uint8_t)code[i]};
        adc_put(scan, i, chips->dead >> i & 1u ? ADC_LOWEST : adc_code(bytes));
    }
}

static enum adc_result read_chips(struct hx711 *chips, uint32_t ready, uint32_t us,
                                  struct adc_scan *scan)
{
    uint32_t code[ADC_MAX_CHANNELS];

    if (!read_codes(chips, code))
        return ADC_WAS_RESET;
    note_dead(chips, ready);
    if (chips->dead == all(chips))
        return ADC_NOT_READY;
    if (us - chips->read_us >= 2u * period_us(chips))
        chips->is_late = 1;
    chips->read_us = us;
    if (chips->n_unsettled > 0) {
        chips->n_unsettled--;
        chips->is_late = 0;
        return ADC_PENDING;
    }
    put(chips, code, scan);
    scan->t_us = us;
    scan->is_late = chips->is_late;
    chips->is_late = 0;
    return ADC_SCAN;
}

enum adc_result hx711_poll(struct hx711 *chips, struct adc_scan *scan)
{
    uint32_t us = chips->io.now_us(chips->io.context);
    uint32_t ready = all(chips) & ~data(chips), alive = all(chips) & ~chips->dead;
    int is_over = us - chips->read_us > MAX_PERIODS * period_us(chips);

    if (ready & chips->silent && us - chips->begun_us >= REVIVE_US)
        return ADC_WAS_RESET;
    chips->silent |= chips->dead & ~ready;
    if (is_over && (ready & alive) == 0)
        return ADC_NOT_READY;
    /* The slowest chip counts. */
    if (!is_over && (ready & alive) != alive)
        return ADC_PENDING;
    return read_chips(chips, ready & alive, us, scan);
}

static enum adc_result begin(void *chips)
{
    struct hx711 *c = chips;
    struct adc_io io = c->io;
    struct hx711_settings settings = c->settings;

    return hx711_begin(c, &io, &settings);
}

static enum adc_result poll(void *chips, struct adc_scan *scan)
{
    return hx711_poll(chips, scan);
}

struct adc hx711_adc(struct hx711 *chips)
{
    struct adc adc = {"hx711", chips, begin, poll};
    return adc;
}
