/* A fake of the ADS131M08 from SBAS950B. Its clock has 8.192 MHz; REFIN is half of the bridges' supply. */
#include <string.h>

#include "fake.h"

#define TCLKIN_NS (1.0e9 / 8.192e6)
#define BRIDGE_V 2.5
#define GAUGE_FACTOR 2.0
enum { N_CHANNELS = 8, N_REGISTERS = 64, FRAME = 30, LONGEST = 64 };
enum { R_ID = 0, R_STATUS = 1, R_MODE = 2, R_CLOCK = 3, R_GAIN1 = 4, R_GAIN2 = 5, R_CFG = 6 };

struct sample {
    int32_t code[N_CHANNELS];
};

static uint16_t registers[N_REGISTERS];
/* The two samples that the chip keeps, the older one first. */
static struct sample kept[2];
static int n_kept, is_selected = 0, is_reset_low;
static uint32_t n_conversions;
static uint64_t next_ns, settled_ns, reset_fall_ns, ready_ns, select_ns, release_ns;
static uint8_t in[LONGEST], out[LONGEST];
static int n_bytes;
static uint16_t answer;
static int answers_status;

/* Table 8-12. */
static void set_defaults(void)
{
    int channel;

    memset(registers, 0, sizeof registers);
    registers[R_ID] = fake_has("other") ? 0x2444 : 0x2847;
    registers[R_STATUS] = 0x0500;
    registers[R_MODE] = 0x0510;
    registers[R_CLOCK] = 0xff0e;
    registers[R_CFG] = 0x0600;
    for (channel = 0; channel < N_CHANNELS; channel++)
        registers[0x0c + 5 * channel] = 0x8000;
}

static unsigned osr(void)
{
    return 128u << (registers[R_CLOCK] >> 2 & 7);
}

/* Section 8.4.3.2: 2 to 65536 modulator clocks of delay and three times the ratio. */
static double period_ns(void)
{
    unsigned delay = 2u << (registers[R_CFG] >> 9 & 15);

    if (registers[R_CFG] & 0x100)
        return (delay + 3.0 * osr()) * 2.0 * TCLKIN_NS;
    return osr() * 2.0 * TCLKIN_NS;
}

/* Filters and samples begin anew; table 8-3, in clocks. */
static void restart(void)
{
    static const unsigned settling[8] = {856, 1112, 1624, 2648, 4696, 8792, 16984, 33368};
    double settle_ns = settling[registers[R_CLOCK] >> 2 & 7] * TCLKIN_NS;

    if (registers[R_CFG] & 0x100)
        settle_ns = 2.0 * period_ns() + 88.0 * TCLKIN_NS;
    n_kept = 0;
    next_ns = fake_ns + (uint64_t)period_ns();
    settled_ns = fake_ns + (uint64_t)settle_ns;
}

static void reset(void)
{
    set_defaults();
    restart();
    answer = 0xff28;
    answers_status = 0;
    ready_ns = fake_ns + 5000;
}

static int32_t convert(int channel, double strain_ue)
{
    unsigned word = registers[channel < 4 ? R_GAIN1 : R_GAIN2];
    double gain = 1u << (word >> 4 * (channel % 4) & 7);
    double full_scale_v = (registers[R_CLOCK] & 0x40 ? 0.96 * BRIDGE_V / 2.0 : 1.2) / gain;

    return fake_code(0.25 * GAUGE_FACTOR * strain_ue * 1.0e-6 * BRIDGE_V / full_scale_v, 8388608.0);
}

static void finish_conversion(void)
{
    struct sample sample;
    int channel;

    for (channel = 0; channel < N_CHANNELS; channel++) {
        double strain_ue = fake_strain_ue((unsigned)channel, n_conversions);
        int is_settled = next_ns >= settled_ns;
        /* Data that is not settled is not held back: it is wrong. */
        sample.code[channel] = is_settled ? convert(channel, strain_ue) : 12345;
        if (is_settled)
            fake_tell((unsigned)channel, strain_ue, sample.code[channel]);
    }
    n_conversions++;
    if (n_kept == 2)
        kept[0] = kept[1];
    else
        n_kept++;
    kept[n_kept - 1] = sample;
}

static void advance(void)
{
    static int has_failed;

    if (registers[R_ID] == 0)
        reset();
    if (fake_has_now("brownout") && !has_failed) {
        has_failed = 1;
        reset();
    }
    while (next_ns <= fake_ns) {
        if (!fake_has_now("silent") && !is_reset_low)
            finish_conversion();
        next_ns += (uint64_t)period_ns();
    }
}

static uint16_t crc(const uint8_t *bytes, int n)
{
    uint32_t remainder = 0xffff;
    int i, bit;

    for (i = 0; i < n; i++)
        for (bit = 7; bit >= 0; bit--) {
            uint32_t top = (remainder >> 15 ^ (uint32_t)bytes[i] >> bit) & 1u;
            remainder = (remainder << 1 & 0xffff) ^ (top ? 0x1021u : 0u);
        }
    return (uint16_t)remainder;
}

static void put24(uint8_t *to, uint32_t word)
{
    to[0] = (uint8_t)(word >> 16);
    to[1] = (uint8_t)(word >> 8);
    to[2] = (uint8_t)word;
}

static uint16_t status(void)
{
    return (uint16_t)(registers[R_STATUS] | (n_kept > 0 ? 0xff : 0));
}

static void prepare_frame(void)
{
    static uint32_t n_frames;
    int channel;

    memset(out, 0, sizeof out);
    put24(out, (uint32_t)(answers_status ? status() : answer) << 8);
    for (channel = 0; channel < N_CHANNELS; channel++)
        put24(out + 3 + 3 * channel, (uint32_t)kept[0].code[channel]);
    put24(out + 27, (uint32_t)crc(out, 27) << 8);
    n_frames++;
    if ((fake_has_now("crc") && n_frames % 4 == 0) || fake_has_now("noise"))
        out[n_frames % 27] ^= 0x10;
}

/* Bits that have to be written as they are (tables 8-16 to 8-20). */
static void check_reserved(unsigned address, uint16_t value)
{
    static const uint16_t reserved[] = {0, 0, 0xc0e0, 0x0020, 0x8888, 0x8888, 0xe000};

    if (address >= R_MODE && address <= R_CFG && value & reserved[address])
        fake_forbidden("%04x in register %02x", value, address);
}

static void write_register(unsigned address, uint16_t value)
{
    if (fake_has("sticky") && address == R_GAIN2)
        return;
    check_reserved(address, value);
    registers[address] = value;
    if (address == R_MODE)
        registers[R_STATUS] = (uint16_t)((registers[R_STATUS] & 0xf0ff) | (value & 0x0f00));
    if (address == R_CLOCK || address == R_CFG)
        restart();
}

static uint16_t word_in(int i)
{
    return (uint16_t)(in[3 * i] << 8 | in[3 * i + 1]);
}

static void obey_write(uint16_t command)
{
    unsigned address = command >> 7 & 63, n = (command & 127u) + 1, i;

    for (i = 0; i < n; i++)
        if (address + i >= R_MODE && address + i <= 0x30)
            write_register(address + i, word_in((int)(1 + i)));
    answer = (uint16_t)(0x4000 | address << 7 | (n - 1));
}

/* Table 8-11. Returns the words that the command takes. */
static int obey(uint16_t command)
{
    answers_status = 0;
    if (command == 0x0011) {
        if (n_bytes >= FRAME)
            reset();
        else
            answer = 0x0011;
    } else if ((command & 0xe000) == 0x6000) {
        obey_write(command);
        return 2 + (command & 127);
    } else if ((command & 0xe07f) == 0xa000) {
        unsigned address = command >> 7 & 63;
        answer = address == R_STATUS ? status() : registers[address];
    } else if (command != 0) {
        fake_forbidden("command %04x", command);
    } else {
        answers_status = 1;
    }
    return 1;
}

static void check_padding(int n_words)
{
    int i;

    for (i = 0; i < n_bytes; i++)
        if (in[i] && (i % 3 == 2 || i >= 3 * n_words))
            fake_forbidden("byte %d of a frame is %02x", i, in[i]);
}

static void finish_frame(void)
{
    if (n_bytes < FRAME)
        fake_forbidden("a frame of %d bytes", n_bytes);
    /* What was shifted out is gone. */
    if (n_kept > 0) {
        kept[0] = kept[1];
        n_kept--;
    }
    check_padding(obey(word_in(0)));
    release_ns = fake_ns;
}

static void select_chip(int level)
{
    if (level == 0 && !is_selected) {
        if (fake_ns < ready_ns)
            fake_forbidden("a frame within tREGACQ");
        if (fake_ns - release_ns < 15)
            fake_forbidden("CS high for less than 15 ns");
        memset(in, 0, sizeof in);
        n_bytes = 0;
        select_ns = fake_ns;
        prepare_frame();
    } else if (level && is_selected) {
        finish_frame();
    }
    is_selected = level == 0;
}

static void sync_reset(int level)
{
    if (level == 0 && !is_reset_low)
        reset_fall_ns = fake_ns;
    if (level && is_reset_low) {
        if ((double)(fake_ns - reset_fall_ns) >= 2048 * TCLKIN_NS)
            reset();
        else
            fake_forbidden("SYNC/RESET low for less than a reset");
    }
    is_reset_low = level == 0;
}

static void pin(unsigned pin, int level)
{
    if (pin == FAKE_CS)
        select_chip(level);
    else if (pin == FAKE_RESET)
        sync_reset(level);
    else
        fake_forbidden("pin %u", pin);
}

static int level(unsigned pin)
{
    (void)pin;
    return n_kept == 0;
}

static uint8_t exchange(uint8_t byte)
{
    if (!is_selected || n_bytes >= LONGEST)
        fake_forbidden("SCLK without CS, or beyond a frame");
    if (n_bytes == 0 && fake_ns - select_ns < 16)
        fake_forbidden("SCLK within 16 ns of CS");
    in[n_bytes] = byte;
    return out[n_bytes++];
}

const struct fake_chip fake_ads131m08 = {"ads131m08", 25000000, advance, pin, level, exchange};
