/* A fake of the ADS1256 from SBAS288K. Its clock has 7.68 MHz; VREF is half of the bridges' supply. */
#include <string.h>

#include "fake.h"

#define TCLKIN_NS (1.0e9 / 7.68e6)
#define BRIDGE_V 5.0
#define GAUGE_FACTOR 2.0
enum { R_STATUS = 0, R_MUX = 1, R_ADCON = 2, R_DRATE = 3, N_REGISTERS = 11 };
enum { WAKEUP = 0x00, RDATA = 0x01, SELFCAL = 0xf0, SYNC = 0xfc };

static uint8_t registers[N_REGISTERS];
static int is_selected, is_reset_low, is_up, is_calibrated, is_calibrating, is_synced, is_ready;
static uint64_t reset_fall_ns, last_sclk_ns, done_ns;
/* A command may not begin before then; data may not be read before then. */
static uint64_t command_ns, data_ns;
/* What is converted, and what the last conversion gave. */
static uint8_t converted_mux;
static int32_t code;
static uint32_t n_conversions;
/* A command under way: bytes of it that are still to come, and answers that are to be read. */
static uint8_t command[16], answers[16];
static int n_command, n_wanted, n_answers, n_read, reads_data;

/* DRATE, samples a second, settling time in ns: tables 11 and 13. */
static const struct rate {
    uint8_t drate;
    double sps, settle_ns;
} rates[] = {
    {0xf0, 30000, 210e3},  {0xe0, 15000, 250e3}, {0xd0, 7500, 310e3},  {0xc0, 3750, 440e3},
    {0xb0, 2000, 680e3},   {0xa1, 1000, 1180e3}, {0x92, 500, 2180e3},  {0x82, 100, 10180e3},
    {0x72, 60, 16840e3},   {0x63, 50, 20180e3},  {0x53, 30, 33510e3},  {0x43, 25, 40180e3},
    {0x33, 15, 66840e3},   {0x23, 10, 100180e3}, {0x13, 5, 200180e3},  {0x03, 2.5, 400180e3}
};

static const struct rate *rate(void)
{
    size_t i;

    for (i = 0; i < sizeof rates / sizeof *rates; i++)
        if (rates[i].drate == registers[R_DRATE])
            return &rates[i];
    fake_forbidden("DRATE of %02x", registers[R_DRATE]);
    return rates;
}

/* Table 23; behind a reset the chip calibrates itself, at 30000 a second in 0.6 ms. */
static void reset(void)
{
    static const uint8_t defaults[N_REGISTERS] = {0x31, 0x01, 0x20, 0xf0, 0xe0};

    memcpy(registers, defaults, sizeof registers);
    if (fake_has("other"))
        registers[R_STATUS] = 0x51;
    is_ready = is_synced = n_command = n_wanted = n_answers = 0;
    is_calibrating = is_calibrated = 1;
    converted_mux = registers[R_MUX];
    done_ns = fake_ns + 600000;
    command_ns = fake_ns;
}

static double convert(double strain_ue)
{
    double gain = 1u << (registers[R_ADCON] & 7);

    return 0.25 * GAUGE_FACTOR * strain_ue * 1.0e-6 * BRIDGE_V / (BRIDGE_V / gain);
}

static void finish_conversion(void)
{
    unsigned channel = converted_mux >> 4;
    double strain_ue = fake_strain_ue(channel, n_conversions++);

    /* Without a calibration the offset is that of another gain. */
    code = fake_code(convert(strain_ue), 8388607.0) + (is_calibrated ? 0 : 1000);
    is_ready = 1;
    fake_tell(channel, strain_ue, code);
}

static void advance(void)
{
    static int has_failed;

    if (!is_up) {
        is_up = 1;
        reset();
    }
    if (fake_has_now("brownout") && !has_failed) {
        has_failed = 1;
        reset();
    }
    while (done_ns <= fake_ns && !is_reset_low && !is_synced) {
        if (is_calibrating)
            is_calibrating = 0, is_ready = 1;
        else if (!fake_has_now("silent") && !fake_has("dead"))
            finish_conversion();
        done_ns += (uint64_t)(1.0e9 / rate()->sps);
    }
}

static void write_registers(void)
{
    unsigned first = command[0] & 15, i;

    for (i = 0; i + 2 < (unsigned)n_command; i++) {
        uint8_t value = command[2 + i];
        if (first + i >= N_REGISTERS || (first + i == R_ADCON && value & 0x80))
            fake_forbidden("%02x in register %02x", value, first + i);
        if (fake_has("sticky") && first + i == R_DRATE)
            continue;
        if (first + i == R_STATUS)
            value = (uint8_t)((registers[R_STATUS] & 0xf1) | (value & 0x0e));
        /* Gain, rate and buffer ask for a new calibration. */
        if (first + i != R_MUX && value != registers[first + i])
            is_calibrated = 0;
        registers[first + i] = value;
    }
    command_ns = fake_ns + (uint64_t)(4 * TCLKIN_NS);
}

static void start_conversion(void)
{
    is_ready = 0;
    is_synced = 0;
    converted_mux = registers[R_MUX];
    done_ns = fake_ns + (uint64_t)rate()->settle_ns;
}

static void calibrate(void)
{
    is_calibrating = is_calibrated = 1;
    is_ready = 0;
    done_ns = fake_ns + (uint64_t)(3.1 * rate()->settle_ns);
}

static void prepare_answers(int n)
{
    n_answers = n;
    n_read = 0;
    data_ns = fake_ns + (uint64_t)(50 * TCLKIN_NS);
}

/* A command that is whole; table 24. */
static void obey(void)
{
    uint8_t first = command[0];
    int i;

    if ((first & 0xf0) == 0x50) {
        write_registers();
    } else if ((first & 0xf0) == 0x10) {
        for (i = 0; i <= (command[1] & 15); i++)
            answers[i] = registers[(first & 15) + i];
        prepare_answers((command[1] & 15) + 1);
        reads_data = 0;
    } else if (first == RDATA) {
        for (i = 0; i < 3; i++)
            answers[i] = (uint8_t)((uint32_t)code >> 8 * (2 - i));
        prepare_answers(3);
        reads_data = 1;
    } else if (first == SYNC) {
        is_synced = 1;
        is_ready = 0;
        command_ns = fake_ns + (uint64_t)(24 * TCLKIN_NS);
    } else if (first == WAKEUP) {
        start_conversion();
    } else if (first == SELFCAL) {
        calibrate();
    } else {
        fake_forbidden("command %02x", first);
    }
    n_command = 0;
}

static int length_of(uint8_t first)
{
    return (first & 0xf0) == 0x10 || (first & 0xf0) == 0x50 ? 2 : 1;
}

static void take(uint8_t byte)
{
    if (n_command == 0) {
        if (fake_ns < command_ns)
            fake_forbidden("command %02x within t11", byte);
        if (is_calibrating)
            fake_forbidden("command %02x during a calibration", byte);
        n_wanted = length_of(byte);
    }
    command[n_command++] = byte;
    if (n_command == 2 && (command[0] & 0xf0) == 0x50)
        n_wanted = 2 + (byte & 15) + 1;
}

static uint8_t answer(void)
{
    uint8_t byte = answers[n_read++];

    if (n_read == 1 && fake_ns < data_ns)
        fake_forbidden("data within t6");
    if (n_read == n_answers) {
        n_answers = 0;
        command_ns = fake_ns + (uint64_t)(4 * TCLKIN_NS);
        if (reads_data)
            is_ready = 0;
    }
    return byte;
}

static uint8_t exchange(uint8_t byte)
{
    if (!is_selected)
        fake_forbidden("SCLK without CS");
    /* Eight clocks; times count from their end. */
    last_sclk_ns = fake_ns + 4167;
    if (n_answers > 0)
        return answer();
    take(byte);
    if (n_command == n_wanted) {
        uint64_t now = fake_ns;
        fake_ns = last_sclk_ns;
        obey();
        fake_ns = now;
    }
    return 0xff;
}

static void pin(unsigned pin, int level)
{
    if (pin == FAKE_CS) {
        if (level && is_selected && fake_ns < last_sclk_ns + (uint64_t)(8 * TCLKIN_NS))
            fake_forbidden("CS high within t10");
        if (level && (n_command > 0 || n_answers > 0))
            fake_forbidden("CS high within a command");
        is_selected = level == 0;
    } else if (pin == FAKE_RESET) {
        if (level == 0 && !is_reset_low)
            reset_fall_ns = fake_ns;
        if (level && is_reset_low) {
            if ((double)(fake_ns - reset_fall_ns) < 4 * TCLKIN_NS)
                fake_forbidden("RESET low for less than 4 clocks");
            reset();
        }
        is_reset_low = level == 0;
    } else {
        fake_forbidden("pin %u", pin);
    }
}

static int level(unsigned pin)
{
    (void)pin;
    return fake_has("stuck") ? 0 : !is_ready;
}

const struct fake_chip fake_ads1256 = {"ads1256", 1920000, advance, pin, level, exchange};
