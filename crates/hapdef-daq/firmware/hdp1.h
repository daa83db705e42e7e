/* HDP1 for devices: packets, a queue that never blocks, the host's commands.
 *
 * C99, no heap, no library but <stdint.h>, <stddef.h>, <string.h>. docs/formats.md has the tables.
 */
#ifndef HDP1_H
#define HDP1_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HDP1_MAJOR 1u
#define HDP1_MINOR 0u
#define HDP1_HEADER_LEN 16u
#define HDP1_MAX_BODY 1536u
/* COBS adds a byte for every 254 and one; one more for the 0x00 behind. */
#define HDP1_MAX_PACKET (HDP1_MAX_BODY + HDP1_MAX_BODY / 254u + 2u)

enum hdp1_type {
    HDP1_DATA = 0x01, HDP1_HELLO = 0x02, HDP1_STATUS = 0x03, HDP1_PONG = 0x04, HDP1_LOG = 0x05,
    HDP1_GET_HELLO = 0x10, HDP1_PING = 0x11, HDP1_START = 0x12, HDP1_STOP = 0x13
};

enum hdp1_flag {
    HDP1_OVERRUN = 1, HDP1_SATURATED = 2, HDP1_BRIDGE_FAULT = 4, HDP1_FIRST_AFTER_BOOT = 8
};

enum hdp1_format { HDP1_I16 = 0, HDP1_U16 = 1, HDP1_I24 = 2, HDP1_I32 = 3, HDP1_F32 = 4 };

struct hdp1_header {
    uint8_t type;
    uint8_t flags;
    uint8_t schema;
    uint8_t channels;
    uint32_t seq;
    uint64_t t_us;
};

struct hdp1_channel {
    uint8_t kind;      /* 0 quarter, 1 half, 2 full bridge, 3 temperature, 4 volt, 5 acceleration,
                          6 angular rate, 7 force, 8 torque, 255 unused */
    uint8_t log2_gain;
    uint16_t skew_16ns;
    float scale;       /* microstrain per count */
    float offset;
    char name[4];
};

struct hdp1_hello {
    uint8_t format;
    uint8_t scans;
    uint32_t rate_mhz; /* scans per 1000 s */
    uint8_t uid[16];
    uint32_t boot_id;
    uint16_t firmware;
    uint8_t n_channels;
    const struct hdp1_channel *channels;
};

struct hdp1_status {
    uint32_t sent, tx_dropped, adc_overruns, rx_crc_errors, uptime_s;
    int16_t temperature_centi_c;
    uint16_t supply_mv;
    uint64_t saturated;
    uint32_t worst_loop_us;
};

/* CRC-32C (Castagnoli) of n bytes. */
uint32_t hdp1_crc32c(const uint8_t *bytes, size_t n);

/* A packet, 0x00 and all, into out; returns its length, or 0 if it is longer than capacity or HDP1
 * allows. */
size_t hdp1_packet(const struct hdp1_header *header, const uint8_t *payload, size_t payload_len,
                   uint8_t *out, size_t capacity);

/* HELLO's payload, 32 + 16 n bytes; returns its length, or 0 if it does not fit. Sets the schema
 * CRC, whose low byte every DATA header carries. */
size_t hdp1_hello_payload(const struct hdp1_hello *hello, uint8_t *out, size_t capacity,
                          uint16_t *schema_crc);

/* STATUS's payload, 40 bytes. */
size_t hdp1_status_payload(const struct hdp1_status *status, uint8_t out[40]);

/* A queue of bytes to the host. hdp1_send never waits: a packet that does not fit as a whole is
 * dropped and counted. */
struct hdp1_tx {
    uint8_t *ring;
    size_t size, head, used;
    uint32_t sent, dropped;
    /* How far the head is in its packet, 2 at most, and that packet's type. */
    uint8_t at, type;
};

void hdp1_tx_init(struct hdp1_tx *tx, uint8_t *ring, size_t size);

/* Queues a packet; 1 if it was taken, 0 if it was dropped. */
int hdp1_send(struct hdp1_tx *tx, const struct hdp1_header *header, const uint8_t *payload,
              size_t payload_len);

/* Queues DATA and moves header->seq on, taken or dropped: the host sees drops as a gap. */
int hdp1_send_data(struct hdp1_tx *tx, struct hdp1_header *header, const uint8_t *payload,
                   size_t payload_len);

/* Queues a 0x00 of its own, which ends whatever the host may have of a packet. */
void hdp1_send_end(struct hdp1_tx *tx);

/* The longest stretch of bytes that can be handed to the port now; take off what it took. */
size_t hdp1_peek(const struct hdp1_tx *tx, const uint8_t **bytes);
void hdp1_taken(struct hdp1_tx *tx, size_t n);

/* Empties the queue; DATA in it counts as dropped. */
void hdp1_clear(struct hdp1_tx *tx);

/* Decodes what the host says. */
struct hdp1_rx {
    uint8_t code[64];
    size_t len;
    uint32_t crc_errors;
};

/* Takes a byte; returns the type of a command when one is whole, else 0. PING's host_ns is set. */
int hdp1_receive(struct hdp1_rx *rx, uint8_t byte, uint64_t *host_ns);

#ifdef __cplusplus
}
#endif
#endif
