/* ADS131M08; see ads131m08.h. Sections and tables are those of SBAS950B. */
#include "ads131m08.h"

#include <string.h>

/* Section 8.5.1.7: a command or an answer, eight channels, a CRC. */
enum { WORD_LEN = 3, FRAME_LEN = 10 * WORD_LEN, CRC_AT = 9 * WORD_LEN };
/* Table 8-11. */
enum { NONE = 0x0000, RESET = 0x0011, RREG = 0xa000, WREG = 0x6000, WREG_ANSWER = 0x4000 };
enum { RESET_ANSWER = 0xff28, ID_MASK = 0xff00, ID = 0x2800 };
/* Table 8-12, the registers that are written: MODE, CLOCK, GAIN1, GAIN2, CFG. */
enum { ID_REGISTER = 0, FIRST_REGISTER = 2, N_REGISTERS = 5 };
/* STATUS, table 8-15. */
enum { STATUS_RESET = 0x0400, STATUS_WORDS = 0x0300, WORDS_OF_24 = 0x0100, STATUS_DRDY = 0x00ff };
/* tw(RSL) is 2048 clocks, 250 us; tREGACQ 5 us. */
static const uint32_t RESET_US = 300, REGISTERS_US = 10;
/* Table 8-3: settled behind 3.3 periods at most; in global chop two. */
static const uint8_t N_UNSETTLED = 4;
/* The modulator runs at 4.096 MHz; global chop waits 16 of its clocks in front of a conversion. */
static const uint32_t MODULATOR_HZ = 4096000u, CHOP_DELAY = 16u;

/* Clocks of the modulator for a scan. */
static uint32_t scan_clocks(const struct ads131m08_settings *settings)
{
    uint32_t osr = (uint32_t)1 << settings->log2_osr;

    /* Equation 8: the filter settles anew for each conversion. */
    return settings->chops ? CHOP_DELAY + 3u * osr : osr;
}

/* Clocks from the middle of what a scan averages to DRDY. */
static uint32_t delay_clocks(const struct ads131m08_settings *settings)
{
    uint32_t osr = (uint32_t)1 << settings->log2_osr;
    uint32_t sinc3 = osr < 1024u ? osr : 1024u;

    /* A chopped scan is the mean of two conversions. Else the filter is a sinc3 of three times its
     * ratio, followed by a mean of what is left of the ratio (table 8-3). */
    return settings->chops ? scan_clocks(settings) : (2u * sinc3 + osr) / 2u;
}

static uint32_t clocks_us(uint32_t clocks)
{
    return clocks * 125u / (MODULATOR_HZ / 8000u);
}

uint32_t ads131m08_rate_mhz(const struct ads131m08_settings *settings)
{
    return (uint32_t)((uint64_t)MODULATOR_HZ * 1000u / scan_clocks(settings));
}

float ads131m08_scale(const struct ads131m08_settings *settings, float gauge_factor)
{
    /* Section 8.3.4: the range is 0.96 of REFIN, and REFIN half the bridge's supply. */
    float full_scale = 0.48f / (float)(1u << settings->log2_gain);

    return adc_quarter_bridge(full_scale, 8388608.0f, gauge_factor);
}

uint16_t ads131m08_crc(const uint8_t *bytes, size_t n)
{
    uint16_t crc = 0xffff;
    int bit;

    while (n--) {
        crc ^= (uint16_t)(*bytes++ << 8);
        for (bit = 0; bit < 8; bit++)
            crc = (uint16_t)(crc & 0x8000u ? crc << 1 ^ 0x1021 : crc << 1);
    }
    return crc;
}

static uint16_t word_at(const uint8_t *bytes)
{
    return (uint16_t)(bytes[0] << 8 | bytes[1]);
}

/* Whether the data line stayed at one level. */
static int is_flat(const uint8_t in[FRAME_LEN])
{
    int i;

    for (i = 1; i < FRAME_LEN; i++)
        if (in[i] != in[0])
            return 0;
    return in[0] == 0x00 || in[0] == 0xff;
}

/* Exchanges a frame that begins with n words of 16 bits. Its full length is always clocked: a short
 * one would leave data in the chip, and RESET in it is ignored. */
static enum adc_result exchange(struct ads131m08 *chip, const uint16_t *words, size_t n,
                                uint8_t in[FRAME_LEN])
{
    uint8_t out[FRAME_LEN] = {0};
    size_t i;

    for (i = 0; i < n; i++) {
        out[WORD_LEN * i] = (uint8_t)(words[i] >> 8);
        out[WORD_LEN * i + 1] = (uint8_t)words[i];
    }
    chip->io.write(chip->io.context, ADC_CS, 0);
    chip->io.exchange(chip->io.context, out, in, FRAME_LEN);
    chip->io.write(chip->io.context, ADC_CS, 1);
    if (is_flat(in))
        return ADC_NO_CHIP;
    return ads131m08_crc(in, CRC_AT) == word_at(in + CRC_AT) ? ADC_OK : ADC_BAD_CRC;
}

/* A command and its answer, which comes with the next frame. */
static enum adc_result command(struct ads131m08 *chip, const uint16_t *words, size_t n,
                               uint16_t *answer)
{
    static const uint16_t none = NONE;
    uint8_t in[FRAME_LEN];
    enum adc_result result = exchange(chip, words, n, in);

    /* tREGACQ, for RESET. */
    chip->io.delay_us(chip->io.context, REGISTERS_US);
    if (result == ADC_OK)
        result = exchange(chip, &none, 1, in);
    *answer = word_at(in);
    return result;
}

static enum adc_result expect(struct ads131m08 *chip, uint16_t word, uint16_t mask,
                              uint16_t expected, enum adc_result otherwise)
{
    uint16_t answer = 0;
    enum adc_result result = command(chip, &word, 1, &answer);

    if (result != ADC_OK)
        return result;
    return (answer & mask) == expected ? ADC_OK : otherwise;
}

static uint16_t read_command(unsigned address)
{
    return (uint16_t)(RREG | address << 7);
}

/* Writes the registers in one command, then reads each back. */
static enum adc_result set_up(struct ads131m08 *chip)
{
    const struct ads131m08_settings *s = &chip->settings;
    uint16_t words[1 + N_REGISTERS] = {
        WREG | FIRST_REGISTER << 7 | (N_REGISTERS - 1),
        /* MODE: words of 24 bits, time-out of SPI, the reset flag cleared, so that it shows a reset. */
        0x0110,
        /* CLOCK: all channels, high resolution. */
        (uint16_t)(0xff02 | (s->has_reference ? 0x40 : 0) | (s->log2_osr - 7) << 2),
        (uint16_t)(0x1111 * s->log2_gain), (uint16_t)(0x1111 * s->log2_gain),
        (uint16_t)(0x0600 | (s->chops ? 0x0100 : 0))
    };
    uint16_t answer = 0;
    enum adc_result result = command(chip, words, 1 + N_REGISTERS, &answer);
    unsigned i;

    if (result == ADC_OK && answer != (words[0] ^ WREG ^ WREG_ANSWER))
        result = ADC_BAD_REGISTER;
    for (i = 0; i < N_REGISTERS && result == ADC_OK; i++)
        result = expect(chip, read_command(FIRST_REGISTER + i), 0xffff, words[1 + i],
                        ADC_BAD_REGISTER);
    return result;
}

/* Holds the pin down and sends RESET: its answer shows that all four wires work. */
static enum adc_result reset(struct ads131m08 *chip)
{
    const struct adc_io *io = &chip->io;
    enum adc_result result;

    io->write(io->context, ADC_CS, 1);
    io->write(io->context, ADC_RESET, 0);
    io->delay_us(io->context, RESET_US);
    io->write(io->context, ADC_RESET, 1);
    io->delay_us(io->context, REGISTERS_US);
    result = expect(chip, RESET, 0xffff, RESET_ANSWER, ADC_OTHER_CHIP);
    if (result == ADC_OK)
        result = expect(chip, read_command(ID_REGISTER), ID_MASK, ID, ADC_OTHER_CHIP);
    return result;
}

enum adc_result ads131m08_begin(struct ads131m08 *chip, const struct adc_io *io,
                                const struct ads131m08_settings *settings)
{
    struct ads131m08 fresh = {*io, *settings, 0, 0, 0, 0, N_UNSETTLED, 0};
    enum adc_result result;

    /* 16384 is 16256 in table 8-17: left out. */
    if (settings->log2_osr < 7 || settings->log2_osr > 13 || settings->log2_gain > 7)
        return ADC_BAD_SETTINGS;
    *chip = fresh;
    chip->period_us = clocks_us(scan_clocks(&chip->settings));
    chip->delay_us = clocks_us(delay_clocks(&chip->settings));
    result = reset(chip);
    if (result == ADC_OK)
        result = set_up(chip);
    chip->last_high_us = chip->last_scan_us = io->now_us(io->context);
    return result;
}

/* Takes a frame of data; ADC_PENDING if there is nothing new in it. */
static enum adc_result read_frame(struct ads131m08 *chip, uint8_t in[FRAME_LEN])
{
    static const uint16_t none = NONE;
    enum adc_result result = exchange(chip, &none, 1, in);
    uint16_t status = word_at(in);

    chip->last_high_us = chip->io.now_us(chip->io.context);
    if (result != ADC_OK)
        return result;
    if (status & STATUS_RESET || (status & STATUS_WORDS) != WORDS_OF_24)
        return ADC_WAS_RESET;
    return status & STATUS_DRDY ? ADC_SCAN : ADC_PENDING;
}

/* Empties the two scans that the chip keeps, whose instants are not known (section 8.5.1.9.1). */
static enum adc_result drain(struct ads131m08 *chip, uint8_t in[FRAME_LEN])
{
    enum adc_result result = read_frame(chip, in);

    if (result == ADC_SCAN || result == ADC_PENDING)
        result = read_frame(chip, in);
    chip->is_late = 1;
    return result == ADC_SCAN ? ADC_PENDING : result;
}

static enum adc_result take(struct ads131m08 *chip, const uint8_t in[FRAME_LEN], uint32_t us,
                            struct adc_scan *scan)
{
    unsigned i;

    chip->last_scan_us = us;
    if (chip->n_unsettled > 0) {
        chip->n_unsettled--;
        return ADC_PENDING;
    }
    memset(scan, 0, sizeof *scan);
    for (i = 0; i < ADS131M08_CHANNELS; i++)
        adc_put(scan, i, adc_code(in + WORD_LEN * (1 + i)));
    scan->t_us = us - chip->delay_us;
    scan->is_late = chip->is_late;
    chip->is_late = 0;
    return ADC_SCAN;
}

enum adc_result ads131m08_poll(struct ads131m08 *chip, struct adc_scan *scan)
{
    uint32_t us = chip->io.now_us(chip->io.context);
    uint32_t quiet_us = us - chip->last_high_us;
    uint8_t in[FRAME_LEN];
    enum adc_result result;

    if (us - chip->last_scan_us > 10u * chip->period_us + 2000u)
        return ADC_NOT_READY;
    if (chip->io.read(chip->io.context, ADC_DRDY)) {
        chip->last_high_us = us;
        return ADC_PENDING;
    }
    if (quiet_us >= chip->period_us)
        return drain(chip, in);
    result = read_frame(chip, in);
    return result == ADC_SCAN ? take(chip, in, us, scan) : result;
}

static enum adc_result begin(void *chip)
{
    struct ads131m08 *c = chip;
    struct adc_io io = c->io;
    struct ads131m08_settings settings = c->settings;

    return ads131m08_begin(c, &io, &settings);
}

static enum adc_result poll(void *chip, struct adc_scan *scan)
{
    return ads131m08_poll(chip, scan);
}

struct adc ads131m08_adc(struct ads131m08 *chip)
{
    struct adc adc = {"ads131m08", chip, begin, poll};
    return adc;
}
