/* The firmware's core on the host: prints packets as hex for tests/firmware.rs to compare. */
#include "../hdp1.h"

#include <stdio.h>
#include <string.h>

static void show(const char *name, const uint8_t *bytes, size_t n)
{
    printf("%s ", name);
    while (n--)
        printf("%02x", *bytes++);
    printf("\n");
}

static void data(void)
{
    static const int16_t samples[10] = {0, 1, -1, 256, -256, 32767, -32768, 100, -100, 7};
    struct hdp1_header header = {HDP1_DATA, 0, 0xa5, 10, 258, 1000000};
    uint8_t payload[20], out[HDP1_MAX_PACKET];
    int i;

    for (i = 0; i < 10; i++) {
        payload[2 * i] = (uint8_t)samples[i];
        payload[2 * i + 1] = (uint8_t)((uint16_t)samples[i] >> 8);
    }
    show("data", out, hdp1_packet(&header, payload, sizeof payload, out, sizeof out));
}

static void hello_and_status(void)
{
    struct hdp1_channel channels[64];
    struct hdp1_hello hello = {HDP1_I32, 1, 1000000, {0}, 7, 3, 64, channels};
    struct hdp1_status status = {1, 2, 3, 4, 5, -612, 4987, (uint64_t)1 << 63 | 1, 640};
    struct hdp1_header header = {HDP1_HELLO, 0, 0, 0, 9, 5000};
    uint8_t payload[32 + 16 * 64], out[HDP1_MAX_PACKET];
    uint16_t schema;
    size_t n;
    int i;

    memcpy(hello.uid, "hapdef simulated", 16);
    for (i = 0; i < 64; i++) {
        struct hdp1_channel channel = {0, 0, 0, 1.0f, 0.0f, {'G', 0, 0, 0}};
        snprintf(channel.name + 1, 3, "%d", i);
        channels[i] = channel;
    }
    n = hdp1_hello_payload(&hello, payload, sizeof payload, &schema);
    header.schema = (uint8_t)schema;
    show("hello", out, hdp1_packet(&header, payload, n, out, sizeof out));
    header.type = HDP1_STATUS;
    n = hdp1_status_payload(&status, payload);
    show("status", out, hdp1_packet(&header, payload, n, out, sizeof out));
}

/* Payloads of every length up to the longest, without zeros: COBS at its block ends. */
static void lengths(void)
{
    static const size_t sizes[] = {0, 1, 233, 234, 235, 236, 487, 488, 489, 490, 1000, 1516};
    uint8_t payload[1517], out[HDP1_MAX_PACKET];
    struct hdp1_header header = {HDP1_LOG, 15, 0xff, 0xff, 0xffffffffu, UINT64_MAX};
    size_t i;

    memset(payload, 0xee, sizeof payload);
    for (i = 0; i < sizeof sizes / sizeof *sizes; i++)
        show("log", out, hdp1_packet(&header, payload, sizes[i], out, sizeof out));
    printf("toolong %zu\n", hdp1_packet(&header, payload, 1517, out, sizeof out));
}

/* A queue of 200 bytes and packets of 42: four fit, the others are dropped, none waits. */
static void queue(void)
{
    static uint8_t ring[200];
    struct hdp1_tx tx;
    struct hdp1_header header = {HDP1_DATA, 0, 0xa5, 10, 0, 0};
    uint8_t payload[20] = {0};
    const uint8_t *bytes;
    size_t n;
    int i;

    hdp1_tx_init(&tx, ring, sizeof ring);
    for (i = 0; i < 40; i++) {
        hdp1_send_data(&tx, &header, payload, sizeof payload);
        /* The port takes 30 bytes of 42 each time. */
        n = hdp1_peek(&tx, &bytes);
        n = n < 30 ? n : 30;
        show("port", bytes, n);
        hdp1_taken(&tx, n);
    }
    while ((n = hdp1_peek(&tx, &bytes)) > 0) {
        show("port", bytes, n);
        hdp1_taken(&tx, n);
    }
    printf("counts %u %u %u\n", (unsigned)tx.sent, (unsigned)tx.dropped, (unsigned)header.seq);
}

/* Commands from standard input: their types as they are understood. */
static void commands(void)
{
    struct hdp1_rx rx = {{0}, 0, 0};
    uint64_t host_ns = 0;
    int byte;

    while ((byte = getchar()) != EOF) {
        int type = hdp1_receive(&rx, (uint8_t)byte, &host_ns);
        if (type)
            printf("command %02x %llu\n", type, (unsigned long long)host_ns);
    }
    printf("bad %u\n", (unsigned)rx.crc_errors);
}

int main(void)
{
    data();
    hello_and_status();
    lengths();
    queue();
    commands();
    return 0;
}
