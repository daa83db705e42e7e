/* The loop of a board: a converter's scans as HDP1 on a port, and answers to the host.
 *
 * HELLO and STATUS go out every second, whether scans are sent or not. Nothing here waits for the
 * host: what does not fit into the queue is dropped and counted.
 */
#ifndef BOARD_H
#define BOARD_H

#include "converter.h"
#include "hdp1.h"

#ifdef __cplusplus
extern "C" {
#endif

/* 380 ms of ten channels at 1 kHz. */
#define BOARD_RING_LEN 16384u

/* The port to the host and the board's clock. None of them may wait. */
struct board_port {
    void *context;
    /* Microseconds since some moment; wraps at 2^32. */
    uint32_t (*now_us)(void *context);
    /* Whether a host has opened the port. */
    int (*is_open)(void *context);
    /* Bytes that the port takes now. */
    size_t (*room)(void *context);
    /* Hands over n bytes, no more than room; returns how many were taken. */
    size_t (*write)(void *context, const uint8_t *bytes, size_t n);
    /* The next byte of the host, or -1. */
    int (*read)(void *context);
};

struct board {
    struct board_port port;
    struct adc adc;
    struct hdp1_hello hello;
    struct hdp1_header data;
    struct hdp1_status status;
    struct hdp1_rx rx;
    struct hdp1_tx tx;
    uint32_t next_hello_us, next_begin_us, last_us, wraps, last_loop_us;
    uint8_t n_damaged; /* scans lost one after another */
    uint8_t is_up, is_running, was_open, has_greeted;
    uint8_t ring[BOARD_RING_LEN];
};

/* Starts a board. hello's channels have to stay; it may describe no more than ADC_MAX_CHANNELS, as
 * integers, one scan a packet. */
void board_begin(struct board *board, const struct board_port *port, const struct adc *adc,
                 const struct hdp1_hello *hello);

/* One turn; call it for ever, more often than scans come. A converter that fails is begun again,
 * once a second, and a LOG packet says why. */
void board_turn(struct board *board);

#ifdef __cplusplus
}
#endif
#endif
