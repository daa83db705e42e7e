/* The loop of a board; see board.h. */
#include "board.h"

#include <string.h>

static const uint32_t SECOND_US = 1000000;
/* One damaged frame is a disturbance, that many in a row are a fault of the chip or its wires. */
static const uint8_t MAX_DAMAGED = 10;
enum { HELLO_LEN = 32 + 16 * 64, TEXT_LEN = 96, BYTES_A_TURN = 64 };

/* Microseconds since boot, for which the port's clock is asked at least once in 71 minutes. */
static uint64_t now_us(struct board *b)
{
    uint32_t us = b->port.now_us(b->port.context);

    if (us < b->last_us)
        b->wraps++;
    b->last_us = us;
    return (uint64_t)b->wraps << 32 | us;
}

static struct hdp1_header header(const struct board *b, uint8_t type, uint64_t t_us)
{
    struct hdp1_header h = {type, 0, b->data.schema, 0, b->data.seq, t_us};
    return h;
}

static void send_hello(struct board *b)
{
    static uint8_t payload[HELLO_LEN];
    struct hdp1_header h;
    uint16_t crc = 0;
    size_t n = hdp1_hello_payload(&b->hello, payload, sizeof payload, &crc);

    b->data.schema = (uint8_t)crc;
    h = header(b, HDP1_HELLO, now_us(b));
    hdp1_send(&b->tx, &h, payload, n);
}

static void send_status(struct board *b)
{
    uint8_t payload[40];
    struct hdp1_header h = header(b, HDP1_STATUS, now_us(b));

    b->status.sent = b->tx.sent;
    b->status.tx_dropped = b->tx.dropped;
    b->status.rx_crc_errors = b->rx.crc_errors;
    b->status.uptime_s = (uint32_t)(h.t_us / SECOND_US);
    hdp1_send(&b->tx, &h, payload, hdp1_status_payload(&b->status, payload));
    b->status.saturated = 0;
    b->status.worst_loop_us = 0;
}

static void send_pong(struct board *b, uint64_t host_ns)
{
    uint64_t t_us = now_us(b);
    uint8_t payload[16];
    struct hdp1_header h = header(b, HDP1_PONG, t_us);
    unsigned i;

    for (i = 0; i < 8; i++) {
        payload[i] = (uint8_t)(host_ns >> 8 * i);
        payload[8 + i] = (uint8_t)(t_us >> 8 * i);
    }
    hdp1_send(&b->tx, &h, payload, sizeof payload);
}

/* Appends a text as far as there is room. */
static size_t append(uint8_t *to, size_t n, const char *text)
{
    while (*text && n < TEXT_LEN)
        to[n++] = (uint8_t)*text++;
    return n;
}

/* LOG: what is wrong with the converter. */
static void complain(struct board *b, enum adc_result result)
{
    uint8_t text[TEXT_LEN];
    struct hdp1_header h = header(b, HDP1_LOG, now_us(b));
    size_t n = append(text, 0, b->adc.name);

    n = append(text, n, ": ");
    n = append(text, n, adc_words(result));
    hdp1_send(&b->tx, &h, text, n);
}

static void begin_converter(struct board *b)
{
    enum adc_result result = b->adc.begin(b->adc.chip);

    b->is_up = result == ADC_OK;
    b->n_damaged = 0;
    b->next_begin_us = b->port.now_us(b->port.context) + SECOND_US;
    if (!b->is_up)
        complain(b, result);
}

static void lose_scan(struct board *b, enum adc_result result)
{
    b->status.adc_overruns++;
    b->data.flags |= HDP1_OVERRUN;
    if (result == ADC_BAD_CRC && ++b->n_damaged < MAX_DAMAGED)
        return;
    complain(b, result);
    begin_converter(b);
}

/* A scan's samples in HELLO's format; returns their length. */
static size_t put_samples(const struct board *b, const struct adc_scan *scan, uint8_t *payload)
{
    unsigned n_bytes = b->hello.format <= HDP1_U16 ? 2 : b->hello.format == HDP1_I24 ? 3 : 4;
    unsigned channel, i;
    size_t n = 0;

    for (channel = 0; channel < b->hello.n_channels; channel++)
        for (i = 0; i < n_bytes; i++)
            payload[n++] = (uint8_t)((uint32_t)scan->code[channel] >> 8 * i);
    return n;
}

static void send_scan(struct board *b, const struct adc_scan *scan)
{
    uint8_t payload[4 * ADC_MAX_CHANNELS];
    uint64_t now = now_us(b);

    b->data.t_us = now - (uint32_t)((uint32_t)now - scan->t_us);
    b->status.saturated |= scan->saturated | scan->faulty;
    if (scan->saturated | scan->faulty)
        b->data.flags |= HDP1_SATURATED;
    if (scan->faulty)
        b->data.flags |= HDP1_BRIDGE_FAULT;
    /* What a dropped packet would have said of the boot and of missing scans, the next one says. */
    if (hdp1_send_data(&b->tx, &b->data, payload, put_samples(b, scan, payload)))
        b->data.flags = 0;
    else
        b->data.flags &= HDP1_OVERRUN | HDP1_FIRST_AFTER_BOOT;
}

static void take_scan(struct board *b, const struct adc_scan *scan)
{
    b->n_damaged = 0;
    if (scan->is_late) {
        b->status.adc_overruns++;
        b->data.flags |= HDP1_OVERRUN;
    }
    if (b->is_running)
        send_scan(b, scan);
}

static void acquire(struct board *b, uint32_t us)
{
    struct adc_scan scan;
    enum adc_result result;

    if (!b->is_up) {
        if ((int32_t)(us - b->next_begin_us) >= 0)
            begin_converter(b);
        return;
    }
    memset(&scan, 0, sizeof scan);
    result = b->adc.poll(b->adc.chip, &scan);
    if (result == ADC_SCAN)
        take_scan(b, &scan);
    else if (result != ADC_PENDING)
        lose_scan(b, result);
}

/* What a host sees first: a 0x00, which ends what the port may still hold, and HELLO. What was queued
 * while nobody listened is old. */
static void greet(struct board *b)
{
    hdp1_clear(&b->tx);
    if (!b->has_greeted)
        b->data.flags |= HDP1_FIRST_AFTER_BOOT;
    b->has_greeted = 1;
    hdp1_send_end(&b->tx);
    send_hello(b);
}

static void pump(struct board *b)
{
    void *context = b->port.context;
    int is_open = b->port.is_open(context);
    size_t room = is_open ? b->port.room(context) : 0, n;
    const uint8_t *bytes;

    if (room > 0 && !b->was_open)
        greet(b);
    n = hdp1_peek(&b->tx, &bytes);
    n = n < room ? n : room;
    if (n > 0)
        hdp1_taken(&b->tx, b->port.write(context, bytes, n));
    /* A host is greeted when the port takes bytes for the first time. */
    b->was_open = (uint8_t)(is_open && (b->was_open || room > 0));
}

static void listen(struct board *b)
{
    uint64_t host_ns = 0;
    int i, byte;

    for (i = 0; i < BYTES_A_TURN && (byte = b->port.read(b->port.context)) >= 0; i++) {
        switch (hdp1_receive(&b->rx, (uint8_t)byte, &host_ns)) {
        case HDP1_GET_HELLO: send_hello(b); break;
        case HDP1_PING: send_pong(b, host_ns); break;
        case HDP1_START: b->is_running = 1; break;
        case HDP1_STOP: b->is_running = 0; break;
        default: break;
        }
    }
}

void board_begin(struct board *b, const struct board_port *port, const struct adc *adc,
                 const struct hdp1_hello *hello)
{
    memset(b, 0, sizeof *b);
    b->port = *port;
    b->adc = *adc;
    b->hello = *hello;
    hdp1_tx_init(&b->tx, b->ring, sizeof b->ring);
    b->data.type = HDP1_DATA;
    b->data.channels = hello->n_channels;
    b->data.flags = HDP1_FIRST_AFTER_BOOT;
    b->is_running = 1;
    b->last_us = b->last_loop_us = port->now_us(port->context);
    b->next_hello_us = b->last_us + SECOND_US;
    send_hello(b);
    begin_converter(b);
}

void board_turn(struct board *b)
{
    uint32_t us = (uint32_t)now_us(b);

    if (us - b->last_loop_us > b->status.worst_loop_us)
        b->status.worst_loop_us = us - b->last_loop_us;
    b->last_loop_us = us;
    acquire(b, us);
    if ((int32_t)(us - b->next_hello_us) >= 0) {
        b->next_hello_us += SECOND_US;
        send_hello(b);
        send_status(b);
    }
    /* A host is greeted before it is answered. */
    pump(b);
    listen(b);
}
