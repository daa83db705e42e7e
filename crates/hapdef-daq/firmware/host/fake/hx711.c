/* A fake of ten HX711 with one clock line, from Avia's data sheet. Each has a clock of its own. */
#include "fake.h"

#define GAUGE_FACTOR 2.0
enum { N_CHIPS = 10, N_BITS = 24 };

static struct chip {
    uint64_t next_ns, ready_ns;
    int is_ready, n_pulses; /* of the reading under way */
    uint32_t word;          /* that is shifted out */
    int input;              /* pulses that chose what is converted */
    uint32_t n_conversions;
    int is_excused; /* it came back in the middle of pulses */
} chips[N_CHIPS];
static int is_high, is_off, is_up;
/* The clock rose before a chip had data: allowed only in order to switch it off. */
static int is_early;
static uint64_t edge_ns;

/* 80 a second, give or take 2 %. */
static uint64_t period_ns(int i)
{
    return 12500000u + (uint64_t)(i % 5) * 60000u;
}

static void reset(void)
{
    int i;

    for (i = 0; i < N_CHIPS; i++) {
        struct chip fresh = {0, 0, 0, 0, 0, 25, chips[i].n_conversions, 0};
        chips[i] = fresh;
        /* Settled behind 50 ms. */
        chips[i].next_ns = fake_ns + 4 * period_ns(i) + (uint64_t)i * 700000u;
    }
    is_off = 0;
}

static int is_away(int i)
{
    return (fake_has_now("silent") && i == 4) || (fake_has("dead") && i == 7);
}

static int32_t convert(int input, double strain_ue)
{
    double gain = input == 25 ? 128.0 : input == 26 ? 32.0 : 64.0;

    return fake_code(0.25 * GAUGE_FACTOR * strain_ue * 1.0e-6 * gain / 0.5, 8388608.0);
}

static void finish_conversion(int i)
{
    struct chip *c = &chips[i];
    double strain_ue = fake_strain_ue((unsigned)i, c->n_conversions++);
    int32_t code;

    if (c->n_pulses > 0 && c->n_pulses < 25 && !c->is_excused)
        fake_forbidden("%d pulses", c->n_pulses);
    if (c->n_pulses >= 25)
        c->input = c->n_pulses;
    code = convert(c->input, strain_ue);
    c->n_pulses = 0;
    c->word = (uint32_t)code & 0xffffff;
    c->is_ready = 1;
    c->ready_ns = fake_ns;
    fake_tell((unsigned)i, strain_ue, code);
}

static void advance(void)
{
    int i;

    if (!is_up) {
        is_up = 1;
        reset();
    }
    if (is_high && fake_ns - edge_ns > 60000)
        is_off = 1;
    for (i = 0; i < N_CHIPS && !is_off; i++)
        while (chips[i].next_ns <= fake_ns) {
            int is_read = chips[i].is_ready && chips[i].n_pulses > 0;
            /* What is being read stays. */
            if (!is_read && !is_away(i))
                finish_conversion(i);
            chips[i].next_ns += period_ns(i);
        }
}

static void rise(void)
{
    int i;

    if (fake_ns - edge_ns < 200)
        fake_forbidden("clock low for less than 0.2 us");
    for (i = 0; i < N_CHIPS; i++) {
        struct chip *c = &chips[i];
        if (is_away(i))
            c->is_excused = 1, c->n_pulses = 0, c->is_ready = 0;
        if (c->is_excused && !c->is_ready)
            continue;
        if (!c->is_ready && c->n_pulses == 0)
            is_early = 1;
        if (c->is_ready && c->n_pulses == 0 && fake_ns - c->ready_ns < 100)
            fake_forbidden("clock within 0.1 us of data");
        if (c->is_ready && ++c->n_pulses >= 25)
            c->is_ready = c->n_pulses < 25;
        else if (!c->is_ready && c->n_pulses >= 25)
            c->n_pulses++;
        if (c->n_pulses > 27)
            fake_forbidden("%d pulses", c->n_pulses);
    }
}

static void pin(unsigned pin, int level)
{
    if (pin != FAKE_SCK)
        fake_forbidden("pin %u", pin);
    if (level && !is_high)
        rise();
    if (!level && is_high) {
        uint64_t high_ns = fake_ns - edge_ns;
        if (high_ns < 200 || (high_ns > 50000 && high_ns <= 60000))
            fake_forbidden("clock high for %lu ns", (unsigned long)high_ns);
        if (is_early && !is_off)
            fake_forbidden("clock without data");
        is_early = 0;
        if (is_off)
            reset();
    }
    if (!!level != is_high)
        edge_ns = fake_ns;
    is_high = !!level;
}

static int level(unsigned pin)
{
    const struct chip *c = &chips[pin - FAKE_DOUT];

    if (pin < FAKE_DOUT || pin >= FAKE_DOUT + N_CHIPS)
        fake_forbidden("pin %u", pin);
    if (is_high && fake_ns - edge_ns < 100)
        fake_forbidden("data within 0.1 us of the clock");
    if (is_away((int)pin - FAKE_DOUT) || is_off || !c->is_ready)
        return 1;
    return c->n_pulses > 0 ? (int)(c->word >> (N_BITS - c->n_pulses) & 1u) : 0;
}

static uint8_t exchange(uint8_t out)
{
    (void)out;
    fake_forbidden("SPI");
    return 0xff;
}

const struct fake_chip fake_hx711 = {"hx711", 0, advance, pin, level, exchange};
