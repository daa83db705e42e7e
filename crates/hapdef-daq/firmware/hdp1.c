/* HDP1 for devices; see hdp1.h. */
#include "hdp1.h"

#include <string.h>

static void put16(uint8_t *p, uint16_t v)
{
    p[0] = (uint8_t)v;
    p[1] = (uint8_t)(v >> 8);
}

static void put32(uint8_t *p, uint32_t v)
{
    put16(p, (uint16_t)v);
    put16(p + 2, (uint16_t)(v >> 16));
}

static void put64(uint8_t *p, uint64_t v)
{
    put32(p, (uint32_t)v);
    put32(p + 4, (uint32_t)(v >> 32));
}

static void put_float(uint8_t *p, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    put32(p, bits);
}

/* CRC-32C by half bytes: 64 bytes of table. Continues from crc. */
static uint32_t crc_more(uint32_t crc, const uint8_t *bytes, size_t n)
{
    static const uint32_t table[16] = {
        0x00000000u, 0x105ec76fu, 0x20bd8edeu, 0x30e349b1u, 0x417b1dbcu, 0x5125dad3u,
        0x61c69362u, 0x7198540du, 0x82f63b78u, 0x92a8fc17u, 0xa24bb5a6u, 0xb21572c9u,
        0xc38d26c4u, 0xd3d3e1abu, 0xe330a81au, 0xf36e6f75u
    };
    while (n--) {
        crc ^= *bytes++;
        crc = (crc >> 4) ^ table[crc & 15u];
        crc = (crc >> 4) ^ table[crc & 15u];
    }
    return crc;
}

uint32_t hdp1_crc32c(const uint8_t *bytes, size_t n)
{
    return ~crc_more(0xffffffffu, bytes, n);
}

/* COBS, a byte at a time. */
struct cobs {
    uint8_t *out;
    size_t at, code_at;
    uint8_t code;
};

static void cobs_put(struct cobs *c, const uint8_t *bytes, size_t n)
{
    while (n--) {
        uint8_t byte = *bytes++;
        if (c->code == 255) {
            c->out[c->code_at] = 255;
            c->code_at = c->at++;
            c->code = 1;
        }
        if (byte) {
            c->out[c->at++] = byte;
            c->code++;
        } else {
            c->out[c->code_at] = c->code;
            c->code_at = c->at++;
            c->code = 1;
        }
    }
}

size_t hdp1_packet(const struct hdp1_header *header, const uint8_t *payload, size_t payload_len,
                   uint8_t *out, size_t capacity)
{
    size_t body_len = HDP1_HEADER_LEN + payload_len + 4u;
    uint8_t head[HDP1_HEADER_LEN], tail[4];
    struct cobs c = {out, 1, 0, 1};
    uint32_t crc;

    if (payload_len > HDP1_MAX_BODY || body_len > HDP1_MAX_BODY ||
        body_len + body_len / 254u + 2u > capacity)
        return 0;
    head[0] = header->type;
    head[1] = (uint8_t)(HDP1_MAJOR << 4 | (header->flags & 15u));
    head[2] = header->schema;
    head[3] = header->channels;
    put32(head + 4, header->seq);
    put64(head + 8, header->t_us);
    crc = crc_more(0xffffffffu, head, sizeof head);
    put32(tail, ~crc_more(crc, payload, payload_len));
    cobs_put(&c, head, sizeof head);
    cobs_put(&c, payload, payload_len);
    cobs_put(&c, tail, sizeof tail);
    out[c.code_at] = c.code;
    out[c.at++] = 0;
    return c.at;
}

size_t hdp1_hello_payload(const struct hdp1_hello *hello, uint8_t *out, size_t capacity,
                          uint16_t *schema_crc)
{
    size_t len = 32u + 16u * hello->n_channels;
    uint32_t crc;
    uint8_t i;

    if (hello->n_channels == 0 || hello->n_channels > 64 || len > capacity)
        return 0;
    out[0] = HDP1_MINOR;
    out[1] = hello->n_channels;
    out[2] = hello->format;
    out[3] = hello->scans;
    put32(out + 4, hello->rate_mhz);
    memcpy(out + 8, hello->uid, 16);
    put32(out + 24, hello->boot_id);
    put16(out + 28, hello->firmware);
    for (i = 0; i < hello->n_channels; i++) {
        const struct hdp1_channel *channel = &hello->channels[i];
        uint8_t *p = out + 32 + 16 * (size_t)i;
        p[0] = channel->kind;
        p[1] = channel->log2_gain;
        put16(p + 2, channel->skew_16ns);
        put_float(p + 4, channel->scale);
        put_float(p + 8, channel->offset);
        memcpy(p + 12, channel->name, 4);
    }
    crc = crc_more(0xffffffffu, out + 1, 7);
    *schema_crc = (uint16_t)~crc_more(crc, out + 32, len - 32);
    put16(out + 30, *schema_crc);
    return len;
}

size_t hdp1_status_payload(const struct hdp1_status *status, uint8_t out[40])
{
    put32(out, status->sent);
    put32(out + 4, status->tx_dropped);
    put32(out + 8, status->adc_overruns);
    put32(out + 12, status->rx_crc_errors);
    put32(out + 16, status->uptime_s);
    put16(out + 20, (uint16_t)status->temperature_centi_c);
    put16(out + 22, status->supply_mv);
    put64(out + 24, status->saturated);
    put32(out + 32, status->worst_loop_us);
    put32(out + 36, 0);
    return 40;
}

void hdp1_tx_init(struct hdp1_tx *tx, uint8_t *ring, size_t size)
{
    memset(tx, 0, sizeof *tx);
    tx->ring = ring;
    tx->size = size;
}

/* Queues bytes; 1 if all of them fit, else none is taken. */
static int enqueue(struct hdp1_tx *tx, const uint8_t *bytes, size_t n)
{
    size_t tail, first;

    if (n == 0 || n > tx->size - tx->used)
        return 0;
    tail = (tx->head + tx->used) % tx->size;
    first = n < tx->size - tail ? n : tx->size - tail;
    memcpy(tx->ring + tail, bytes, first);
    memcpy(tx->ring, bytes + first, n - first);
    tx->used += n;
    return 1;
}

int hdp1_send(struct hdp1_tx *tx, const struct hdp1_header *header, const uint8_t *payload,
              size_t payload_len)
{
    static uint8_t packet[HDP1_MAX_PACKET];

    return enqueue(tx, packet, hdp1_packet(header, payload, payload_len, packet, sizeof packet));
}

void hdp1_send_end(struct hdp1_tx *tx)
{
    static const uint8_t end = 0;

    enqueue(tx, &end, 1);
}

int hdp1_send_data(struct hdp1_tx *tx, struct hdp1_header *header, const uint8_t *payload,
                   size_t payload_len)
{
    int taken = hdp1_send(tx, header, payload, payload_len);

    if (taken)
        tx->sent++;
    else
        tx->dropped++;
    header->seq++;
    return taken;
}

size_t hdp1_peek(const struct hdp1_tx *tx, const uint8_t **bytes)
{
    size_t to_end = tx->size - tx->head;

    *bytes = tx->ring + tx->head;
    return tx->used < to_end ? tx->used : to_end;
}

/* Takes the head's byte off the queue; 1 if it ends a packet of DATA. */
static int take_byte(struct hdp1_tx *tx)
{
    uint8_t byte = tx->ring[tx->head];
    int is_end = byte == 0, is_data = tx->at == 2 && tx->type == HDP1_DATA;

    /* The first byte is COBS's, the second the type, which is not 0. */
    if (tx->at == 1)
        tx->type = byte;
    tx->at = is_end ? 0 : tx->at < 2 ? tx->at + 1 : 2;
    tx->head = (tx->head + 1) % tx->size;
    tx->used--;
    return is_end && is_data;
}

void hdp1_taken(struct hdp1_tx *tx, size_t n)
{
    while (n-- > 0)
        take_byte(tx);
}

void hdp1_clear(struct hdp1_tx *tx)
{
    while (tx->used > 0)
        if (take_byte(tx)) {
            tx->sent--;
            tx->dropped++;
        }
}

/* Decodes COBS in place; returns the length, or 0 if it does not add up. */
static size_t cobs_decode(uint8_t *code, size_t len)
{
    size_t from = 0, to = 0;

    while (from < len) {
        uint8_t n = code[from++], i;
        if (n == 0 || n - 1u > len - from)
            return 0;
        for (i = 1; i < n; i++)
            code[to++] = code[from++];
        if (n < 255 && from < len)
            code[to++] = 0;
    }
    return to;
}

static uint32_t get32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

int hdp1_receive(struct hdp1_rx *rx, uint8_t byte, uint64_t *host_ns)
{
    size_t len = rx->len;

    if (byte) {
        if (len < sizeof rx->code)
            rx->code[len] = byte;
        /* One beyond the buffer marks a packet that is too long. */
        rx->len = len < sizeof rx->code ? len + 1 : sizeof rx->code + 1;
        return 0;
    }
    rx->len = 0;
    if (len == 0)
        return 0;
    len = len <= sizeof rx->code ? cobs_decode(rx->code, len) : 0;
    if (len < HDP1_HEADER_LEN + 4u ||
        hdp1_crc32c(rx->code, len - 4) != get32(rx->code + len - 4)) {
        rx->crc_errors++;
        return 0;
    }
    if (rx->code[1] >> 4 != HDP1_MAJOR)
        return 0;
    if (rx->code[0] == HDP1_PING) {
        if (len < HDP1_HEADER_LEN + 8u + 4u)
            return 0;
        *host_ns = get32(rx->code + 16) | (uint64_t)get32(rx->code + 20) << 32;
    }
    return rx->code[0];
}
