/* ADS1256; see ads1256.h. Tables and timing are those of SBAS288K. */
#include "ads1256.h"

#include <string.h>

/* Table 24. */
enum { WAKEUP = 0x00, RDATA = 0x01, RREG = 0x10, WREG = 0x50, SELFCAL = 0xf0, SYNC = 0xfc };
/* Table 23: STATUS, MUX, ADCON, DRATE. */
enum { STATUS = 0, MUX = 1, N_REGISTERS = 4 };
/* The data sheet does not give the identity; all chips seen by public drivers say 3. */
enum { ID = 3, BUFFER = 0x02, ORDER_CALIBRATION_BUFFER = 0x0e };
/* In clocks of 130 ns, rounded up: t11 is 4 behind a read or write and 24 behind SYNC, t6 is 50, t10
 * is 8, a reset pulse 4. */
static const uint32_t T11_US = 1, T11_SYNC_US = 4, T6_US = 7, T10_US = 2, RESET_US = 10;
/* A crystal's start, and the calibration behind a reset. */
static const uint32_t START_US = 50000, RISE_US = 500;
static const uint32_t CHECK_US = 1000000;

/* DRATE; table 13, the settling time of a conversion that was started anew; table 14, inputs per 1000
 * seconds. */
static const struct {
    uint8_t drate;
    uint32_t settle_us, inputs_mhz;
} rates[ADS1256_N_RATES] = {
    {0xf0, 210, 4374000},   {0xe0, 250, 3817000},   {0xd0, 310, 3043000},
    {0xc0, 440, 2165000},   {0xb0, 680, 1438000},   {0xa1, 1180, 837000},
    {0x92, 2180, 456000},   {0x82, 10180, 98000},   {0x72, 16840, 59000},
    {0x63, 20180, 50000},   {0x53, 33510, 30000},   {0x43, 40180, 25000},
    {0x33, 66840, 15000},   {0x23, 100180, 10000},  {0x13, 200180, 5000}
};

static uint32_t settle_us(const struct ads1256 *chip)
{
    return rates[chip->settings.rate].settle_us;
}

uint32_t ads1256_rate_mhz(const struct ads1256_settings *settings)
{
    return rates[settings->rate].inputs_mhz / settings->n_inputs;
}

uint16_t ads1256_skew_16ns(const struct ads1256_settings *settings, unsigned input)
{
    uint64_t skew = 62500000000u * (uint64_t)input / rates[settings->rate].inputs_mhz;

    return skew < 0xffff ? (uint16_t)skew : 0xffff;
}

float ads1256_scale(const struct ads1256_settings *settings, float gauge_factor)
{
    /* The range is twice VREF over the gain (table 8), and twice VREF is the bridge's supply. */
    return adc_quarter_bridge(1.0f / (float)(1u << settings->log2_gain), 8388607.0f, gauge_factor);
}

static void send(struct ads1256 *chip, const uint8_t *bytes, size_t n, uint32_t delay_us)
{
    uint8_t in[2 + N_REGISTERS];

    chip->io.exchange(chip->io.context, bytes, in, n);
    chip->io.delay_us(chip->io.context, delay_us);
}

static void select_chip(struct ads1256 *chip)
{
    chip->io.write(chip->io.context, ADC_CS, 0);
}

static void release_chip(struct ads1256 *chip)
{
    chip->io.delay_us(chip->io.context, T10_US);
    chip->io.write(chip->io.context, ADC_CS, 1);
}

/* Answers to what was sent last, t6 behind it. */
static void receive(struct ads1256 *chip, uint8_t *bytes, size_t n)
{
    static const uint8_t zeros[N_REGISTERS];

    chip->io.exchange(chip->io.context, zeros, bytes, n);
}

static void read_registers(struct ads1256 *chip, uint8_t values[N_REGISTERS])
{
    static const uint8_t command[] = {RREG | STATUS, N_REGISTERS - 1};

    select_chip(chip);
    send(chip, command, sizeof command, T6_US);
    receive(chip, values, N_REGISTERS);
    release_chip(chip);
}

/* What the registers have to be while an input is converted. */
static void wanted(const struct ads1256 *chip, uint8_t values[N_REGISTERS])
{
    const struct ads1256_settings *s = &chip->settings;

    values[0] = s->buffers ? BUFFER : 0;
    values[1] = s->mux[chip->input];
    values[2] = s->log2_gain; /* clock output off */
    values[3] = rates[s->rate].drate;
}

static void write_registers(struct ads1256 *chip)
{
    uint8_t bytes[2 + N_REGISTERS] = {WREG | STATUS, N_REGISTERS - 1};

    wanted(chip, bytes + 2);
    select_chip(chip);
    send(chip, bytes, sizeof bytes, T11_US);
    release_chip(chip);
}

/* Whether the chip holds its settings; identity and DRDY in STATUS aside. */
static int keeps_settings(struct ads1256 *chip)
{
    uint8_t values[N_REGISTERS], expected[N_REGISTERS];

    read_registers(chip, values);
    wanted(chip, expected);
    values[STATUS] &= ORDER_CALIBRATION_BUFFER;
    return memcmp(values, expected, N_REGISTERS) == 0;
}

static enum adc_result wait_for(struct ads1256 *chip, int level, uint32_t limit_us)
{
    const struct adc_io *io = &chip->io;
    uint32_t from_us = io->now_us(io->context);

    while (!io->read(io->context, ADC_DRDY) != !level) {
        if (io->now_us(io->context) - from_us > limit_us)
            return ADC_NOT_READY;
        io->delay_us(io->context, 10);
    }
    return ADC_OK;
}

/* Waits while the chip calibrates itself: DRDY rises, and falls when it is done. A line that is always
 * low would seem to be done at once, and the chip must not be spoken to before. */
static enum adc_result wait_calibrated(struct ads1256 *chip, uint32_t limit_us)
{
    enum adc_result result = wait_for(chip, 1, RISE_US);

    return result == ADC_OK ? wait_for(chip, 0, limit_us) : result;
}

static enum adc_result identify(struct ads1256 *chip)
{
    uint8_t values[N_REGISTERS];

    read_registers(chip, values);
    if (memcmp(values, values + 1, N_REGISTERS - 1) == 0 && (values[0] == 0 || values[0] == 0xff))
        return ADC_NO_CHIP;
    return values[STATUS] >> 4 == ID ? ADC_OK : ADC_OTHER_CHIP;
}

static enum adc_result reset(struct ads1256 *chip)
{
    const struct adc_io *io = &chip->io;
    enum adc_result ready, identity;

    io->write(io->context, ADC_CS, 1);
    io->write(io->context, ADC_RESET, 0);
    io->delay_us(io->context, RESET_US);
    io->write(io->context, ADC_RESET, 1);
    io->delay_us(io->context, RESET_US);
    ready = wait_calibrated(chip, START_US);
    /* Low for ever: it may be calibrating. High for ever: perhaps it is not there. */
    if (ready != ADC_OK && !io->read(io->context, ADC_DRDY))
        return ready;
    identity = identify(chip);
    return identity == ADC_OK ? ready : identity;
}

static enum adc_result calibrate(struct ads1256 *chip)
{
    static const uint8_t command = SELFCAL;

    select_chip(chip);
    send(chip, &command, 1, T11_US);
    release_chip(chip);
    /* Table 21 has 3.1 settling times at 2.5 a second; at high rates the start counts as well. */
    return wait_calibrated(chip, 4u * settle_us(chip) + 10000u);
}

/* Starts an input's conversion, then reads the one before into code (figure 19): in this order the
 * reading costs no time. */
static void cycle(struct ads1256 *chip, uint8_t input, int32_t *code)
{
    uint8_t mux[3] = {WREG | MUX, 0, chip->settings.mux[input]}, bytes[3];
    static const uint8_t sync = SYNC, wakeup = WAKEUP, rdata = RDATA;

    select_chip(chip);
    send(chip, mux, sizeof mux, T11_US);
    send(chip, &sync, 1, T11_SYNC_US);
    send(chip, &wakeup, 1, T11_US);
    chip->started_us = chip->io.now_us(chip->io.context);
    send(chip, &rdata, 1, T6_US);
    receive(chip, bytes, sizeof bytes);
    release_chip(chip);
    chip->input = input;
    *code = adc_code(bytes);
}

enum adc_result ads1256_begin(struct ads1256 *chip, const struct adc_io *io,
                              const struct ads1256_settings *settings)
{
    enum adc_result result;
    int32_t code;

    if (settings->n_inputs < 1 || settings->n_inputs > ADS1256_MAX_INPUTS ||
        settings->log2_gain > 6 || settings->rate >= ADS1256_N_RATES)
        return ADC_BAD_SETTINGS;
    memset(chip, 0, sizeof *chip);
    chip->io = *io;
    chip->settings = *settings;
    result = reset(chip);
    if (result != ADC_OK)
        return result;
    write_registers(chip);
    if (!keeps_settings(chip))
        return ADC_BAD_REGISTER;
    result = calibrate(chip);
    if (result == ADC_OK)
        cycle(chip, 0, &code);
    chip->checked_us = chip->started_us;
    return result;
}

/* What is checked between scans: DRDY goes high when an input is started, and the registers hold. */
static enum adc_result check(struct ads1256 *chip, uint32_t us)
{
    if (!chip->io.read(chip->io.context, ADC_DRDY))
        return ADC_NOT_READY;
    if (us - chip->checked_us < CHECK_US || chip->input != 0)
        return ADC_OK;
    chip->checked_us = us;
    return keeps_settings(chip) ? ADC_OK : ADC_WAS_RESET;
}

enum adc_result ads1256_poll(struct ads1256 *chip, struct adc_scan *scan)
{
    uint32_t us = chip->io.now_us(chip->io.context), waited_us = us - chip->started_us;
    uint8_t input = chip->input;
    uint8_t next = (uint8_t)((input + 1u) % chip->settings.n_inputs);
    enum adc_result result;
    int32_t code;

    if (chip->io.read(chip->io.context, ADC_DRDY))
        return waited_us > 4u * settle_us(chip) + 2000u ? ADC_NOT_READY : ADC_PENDING;
    if (input == 0) {
        memset(&chip->scan, 0, sizeof chip->scan);
        /* The middle of what the first input's conversion averaged. */
        chip->scan.t_us = chip->started_us + settle_us(chip) / 2u;
    }
    /* The chip has converted this input twice: a scan of the promised rate is missing. */
    if (waited_us >= 2u * settle_us(chip) + 100u)
        chip->scan.is_late = 1;
    cycle(chip, next, &code);
    adc_put(&chip->scan, input, code);
    result = check(chip, us);
    if (result != ADC_OK || next != 0)
        return result == ADC_OK ? ADC_PENDING : result;
    *scan = chip->scan;
    return ADC_SCAN;
}

static enum adc_result begin(void *chip)
{
    struct ads1256 *c = chip;
    struct adc_io io = c->io;
    struct ads1256_settings settings = c->settings;

    return ads1256_begin(c, &io, &settings);
}

static enum adc_result poll(void *chip, struct adc_scan *scan)
{
    return ads1256_poll(chip, scan);
}

struct adc ads1256_adc(struct ads1256 *chip)
{
    struct adc adc = {"ads1256", chip, begin, poll};
    return adc;
}
