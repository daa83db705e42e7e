/* Ten quarter bridges on an Arduino Due at 1 kHz, as HDP1 over the native USB port.
 *
 * Copy hdp1, board and converter (.h and .c of each) beside this file, open it in the Arduino IDE (board:
 * Arduino Due, native USB port). docs/board.md has the wiring. Set GAIN to that of your amplifiers.
 */
#include "board.h"

static const uint8_t N = 10;
static const uint32_t PERIOD_US = 1000;
static const float GAIN = 500.0f;
/* A quarter bridge at gauge factor 2 and 3.3 V gives 1.65 uV a microstrain; a count of 12 bits over
 * 3.3 V is 806 uV behind the amplifier. */
static const float UE_PER_COUNT = 3.3e6f / 4096.0f / (1.65f * GAIN);
static const uint8_t FIRST_PIN = A0;

static struct hdp1_channel channels[N];
static struct board board;
static uint32_t next_us;

static uint32_t now_us(void *)
{
    return micros();
}

static int is_open(void *)
{
    return SerialUSB.dtr();
}

/* Bytes go to the port only if a whole bank of its FIFO is free: the core's write waits for one, for
 * ever if the host has closed the port without saying so. */
static size_t room(void *)
{
    return UOTGHS->UOTGHS_DEVEPTISR[CDC_TX] & UOTGHS_DEVEPTISR_TXINI ? 512 : 0;
}

static size_t write_port(void *, const uint8_t *bytes, size_t n)
{
    return SerialUSB.write(bytes, n);
}

static int read_port(void *)
{
    return SerialUSB.available() ? SerialUSB.read() : -1;
}

static enum adc_result begin_scans(void *)
{
    next_us = micros();
    return ADC_OK;
}

static void convert(struct adc_scan *scan)
{
    scan->t_us = micros();
    for (uint8_t i = 0; i < N; i++) {
        int value = analogRead(FIRST_PIN + i);
        scan->code[i] = value;
        if (value < 8 || value > 4087)
            scan->saturated |= 1u << i;
    }
}

/* A scan every PERIOD_US. */
static enum adc_result poll_scan(void *, struct adc_scan *scan)
{
    uint32_t us = micros();

    if ((int32_t)(us - next_us) < 0)
        return ADC_PENDING;
    next_us += PERIOD_US;
    if ((int32_t)(us - next_us) >= 0) {
        /* More than a period late: scans are missing. */
        scan->is_late = 1;
        next_us = us + PERIOD_US;
    }
    convert(scan);
    return ADC_SCAN;
}

/* The chip's own number. While the flash shows it no code can be read from that bank: this runs in
 * RAM, and no interrupt may come. */
__attribute__((section(".ramfunc"), noinline)) static void read_uid(uint8_t uid[16])
{
    EFC1->EEFC_FCR = EEFC_FCR_FKEY(0x5Au) | EEFC_FCR_FCMD(EFC_FCMD_STUI);
    while (EFC1->EEFC_FSR & EEFC_FSR_FRDY) {
    }
    for (int i = 0; i < 16; i++)
        uid[i] = ((const volatile uint8_t *)IFLASH1_ADDR)[i];
    EFC1->EEFC_FCR = EEFC_FCR_FKEY(0x5Au) | EEFC_FCR_FCMD(EFC_FCMD_SPUI);
    while (!(EFC1->EEFC_FSR & EEFC_FSR_FRDY)) {
    }
}

/* A number that differs from boot to boot, by the chip's random generator. */
static uint32_t random_number()
{
    pmc_enable_periph_clk(ID_TRNG);
    TRNG->TRNG_CR = TRNG_CR_KEY(0x524e47) | TRNG_CR_ENABLE;
    while (!(TRNG->TRNG_ISR & TRNG_ISR_DATRDY)) {
    }
    return TRNG->TRNG_ODATA;
}

void setup()
{
    struct hdp1_hello hello = {HDP1_U16, 1, 1000000, {0}, 0, 1, N, channels};
    struct board_port port = {0, now_us, is_open, room, write_port, read_port};
    struct adc adc = {"due", 0, begin_scans, poll_scan};

    SerialUSB.begin(115200);
    analogReadResolution(12);
    for (uint8_t i = 0; i < N; i++) {
        struct hdp1_channel c = {0, 9, 0, UE_PER_COUNT, 0.0f, {'G', (char)('0' + i), 0, 0}};
        /* One conversion with the core's overhead takes about 4 us. */
        c.skew_16ns = (uint16_t)(i * 250u);
        channels[i] = c;
    }
    noInterrupts();
    read_uid(hello.uid);
    interrupts();
    hello.boot_id = random_number();
    board_begin(&board, &port, &adc, &hello);
}

void loop()
{
    board_turn(&board);
}
