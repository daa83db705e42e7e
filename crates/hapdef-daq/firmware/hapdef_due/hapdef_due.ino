/* Ten quarter bridges on an Arduino Due at 1 kHz, as HDP1 over the native USB port.
 *
 * Copy hdp1.h and hdp1.c beside this file, open it in the Arduino IDE (board: Arduino Due, native
 * USB port). docs/board.md has the wiring. Set GAIN to that of your amplifiers.
 */
#include "hdp1.h"

static const uint8_t N = 10;
static const uint32_t PERIOD_US = 1000;
/* HELLO and STATUS come that often, whether scans are sent or not. */
static const uint32_t HELLO_US = 1000000;
static const float GAIN = 500.0f;
/* A quarter bridge at gauge factor 2 and 3.3 V gives 1.65 uV a microstrain; a count of 12 bits over
 * 3.3 V is 806 uV behind the amplifier. */
static const float UE_PER_COUNT = 3.3e6f / 4096.0f / (1.65f * GAIN);
static const uint8_t FIRST_PIN = A0;

static struct hdp1_channel channels[N];
static struct hdp1_hello hello = {
    HDP1_U16, 1, 1000000, {0}, 0, 1, N, channels
};
static struct hdp1_header data_header;
static struct hdp1_status status;
static struct hdp1_rx rx;
static struct hdp1_tx tx;
static uint8_t ring[16384];
static uint8_t hello_bytes[32 + 16 * N];
static uint8_t schema;
static uint32_t next_us, next_hello_us, last_us, wraps, last_loop_us;
static bool is_running = true;

/* Microseconds since boot; micros() wraps every 71 minutes. */
static uint64_t now_us()
{
    uint32_t us = micros();
    if (us < last_us)
        wraps++;
    last_us = us;
    return (uint64_t)wraps << 32 | us;
}

static struct hdp1_header header(uint8_t type, uint64_t t_us)
{
    struct hdp1_header h = {type, 0, schema, 0, data_header.seq, t_us};
    return h;
}

/* HELLO's header, and its payload in hello_bytes. */
static struct hdp1_header describe(size_t *n)
{
    uint16_t crc;

    *n = hdp1_hello_payload(&hello, hello_bytes, sizeof hello_bytes, &crc);
    schema = (uint8_t)crc;
    data_header.schema = schema;
    return header(HDP1_HELLO, now_us());
}

static void send_hello()
{
    size_t n;
    struct hdp1_header h = describe(&n);

    hdp1_send(&tx, &h, hello_bytes, n);
}

/* What a host sees first: a 0x00, which ends what the port may still hold, and HELLO. What was queued
 * while nobody listened is old. */
static void greet()
{
    static uint8_t bytes[sizeof hello_bytes + 64];
    static bool is_later;
    size_t n;
    struct hdp1_header h = describe(&n);

    hdp1_clear(&tx);
    if (!is_later)
        data_header.flags |= HDP1_FIRST_AFTER_BOOT;
    is_later = true;
    bytes[0] = 0;
    n = hdp1_packet(&h, hello_bytes, n, bytes + 1, sizeof bytes - 1);
    SerialUSB.write(bytes, 1 + n);
}

static void send_status()
{
    uint8_t payload[40];
    struct hdp1_header h = header(HDP1_STATUS, now_us());

    status.sent = tx.sent;
    status.tx_dropped = tx.dropped;
    status.rx_crc_errors = rx.crc_errors;
    status.uptime_s = (uint32_t)(h.t_us / 1000000u);
    hdp1_send(&tx, &h, payload, hdp1_status_payload(&status, payload));
    status.saturated = 0;
    status.worst_loop_us = 0;
}

static void send_scan()
{
    uint8_t payload[2 * N];
    bool is_saturated = false;

    data_header.t_us = now_us();
    for (uint8_t i = 0; i < N; i++) {
        uint16_t value = (uint16_t)analogRead(FIRST_PIN + i);
        if (value < 8 || value > 4087) {
            is_saturated = true;
            status.saturated |= (uint64_t)1 << i;
        }
        payload[2 * i] = (uint8_t)value;
        payload[2 * i + 1] = (uint8_t)(value >> 8);
    }
    if (is_saturated)
        data_header.flags |= HDP1_SATURATED;
    /* What a dropped packet would have said of the boot and of missing scans, the next one says. */
    if (hdp1_send_data(&tx, &data_header, payload, sizeof payload))
        data_header.flags = 0;
    else
        data_header.flags &= (uint8_t)~HDP1_SATURATED;
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

/* Hands bytes to the port only if a whole bank of its FIFO is free: the core's write waits for one,
 * for ever if the host has closed the port without saying so. */
static void pump()
{
    static bool was_open;
    const uint8_t *bytes;
    size_t n = hdp1_peek(&tx, &bytes);
    bool is_open = SerialUSB.dtr();
    bool is_free = UOTGHS->UOTGHS_DEVEPTISR[CDC_TX] & UOTGHS_DEVEPTISR_TXINI;

    if (is_open && is_free && !was_open)
        greet();
    else if (is_open && is_free && n > 0)
        hdp1_taken(&tx, SerialUSB.write(bytes, n < 512 ? n : 512));
    was_open = is_open && (was_open || is_free);
}

static void listen()
{
    for (int i = 0; i < 64 && SerialUSB.available(); i++) {
        uint64_t host_ns;
        switch (hdp1_receive(&rx, (uint8_t)SerialUSB.read(), &host_ns)) {
        case HDP1_GET_HELLO:
            send_hello();
            break;
        case HDP1_PING: {
            uint64_t t_us = now_us();
            uint8_t payload[16];
            struct hdp1_header h = header(HDP1_PONG, t_us);
            memcpy(payload, &host_ns, 8);
            memcpy(payload + 8, &t_us, 8);
            hdp1_send(&tx, &h, payload, sizeof payload);
            break;
        }
        case HDP1_START:
            is_running = true;
            break;
        case HDP1_STOP:
            is_running = false;
            break;
        }
    }
}

void setup()
{
    SerialUSB.begin(115200);
    analogReadResolution(12);
    hdp1_tx_init(&tx, ring, sizeof ring);
    for (uint8_t i = 0; i < N; i++) {
        struct hdp1_channel c = {0, 9, 0, UE_PER_COUNT, 0.0f, {'G', (char)('0' + i), 0, 0}};
        /* One conversion with the core's overhead takes about 4 us. */
        c.skew_16ns = (uint16_t)(i * 250u);
        channels[i] = c;
    }
    noInterrupts();
    read_uid(hello.uid);
    interrupts();
    /* A number that differs from boot to boot, by the chip's random generator. */
    pmc_enable_periph_clk(ID_TRNG);
    TRNG->TRNG_CR = TRNG_CR_KEY(0x524e47) | TRNG_CR_ENABLE;
    while (!(TRNG->TRNG_ISR & TRNG_ISR_DATRDY)) {
    }
    hello.boot_id = TRNG->TRNG_ODATA;
    data_header.type = HDP1_DATA;
    data_header.channels = N;
    data_header.flags = HDP1_FIRST_AFTER_BOOT;
    send_hello();
    next_us = last_loop_us = micros();
    next_hello_us = next_us + HELLO_US;
}

void loop()
{
    uint32_t us = micros();

    if (us - last_loop_us > status.worst_loop_us)
        status.worst_loop_us = us - last_loop_us;
    last_loop_us = us;
    if ((int32_t)(us - next_us) >= 0) {
        next_us += PERIOD_US;
        if ((int32_t)(us - next_us) >= 0) {
            /* More than a period late: scans are missing. */
            status.adc_overruns++;
            data_header.flags |= HDP1_OVERRUN;
            next_us = us + PERIOD_US;
        }
        if (is_running)
            send_scan();
    }
    if ((int32_t)(us - next_hello_us) >= 0) {
        next_hello_us += HELLO_US;
        send_hello();
        send_status();
    }
    /* A host is greeted before it is answered. */
    pump();
    listen();
}
