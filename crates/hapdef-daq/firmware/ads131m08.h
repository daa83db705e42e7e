/* ADS131M08: eight channels at once, 24 bits, by SPI. Data sheet: TI SBAS950B.
 *
 * Clock 8.192 MHz, high-resolution mode, words of 24 bits. begin takes 1 ms, whatever the chip does;
 * poll takes a frame: 30 bytes.
 */
#ifndef ADS131M08_H
#define ADS131M08_H

#include "converter.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ADS131M08_CHANNELS 8u
/* CPOL 0, CPHA 1. */
#define ADS131M08_SPI_MODE 1
#define ADS131M08_SPI_MAX_HZ 25000000u

struct ads131m08_settings {
    uint8_t log2_osr;  /* 7 to 13: 4.096 MHz over 2^that scans a second, 1000 at 12 */
    uint8_t log2_gain; /* 0 to 7, of all channels */
    /* REFIN, 1.25 V, instead of the chip's own 1.2 V: from the bridge's supply its drift cancels. */
    uint8_t has_reference;
    /* Global chop: half the offset's drift, at a third of the scans. */
    uint8_t chops;
};

struct ads131m08 {
    struct adc_io io;
    struct ads131m08_settings settings;
    uint32_t period_us, delay_us;
    uint32_t last_high_us; /* when there was certainly nothing to read */
    uint32_t last_scan_us;
    uint8_t n_unsettled, is_late;
};

/* Scans per 1000 s. */
uint32_t ads131m08_rate_mhz(const struct ads131m08_settings *settings);

/* Microstrain per count of a quarter bridge whose supply is twice REFIN. */
float ads131m08_scale(const struct ads131m08_settings *settings, float gauge_factor);

/* CRC-16 of the chip's frames: CCITT, from FFFF. */
uint16_t ads131m08_crc(const uint8_t *bytes, size_t n);

enum adc_result ads131m08_begin(struct ads131m08 *chip, const struct adc_io *io,
                                const struct ads131m08_settings *settings);

enum adc_result ads131m08_poll(struct ads131m08 *chip, struct adc_scan *scan);

/* The chip for a board; io and settings in it have to be set. */
struct adc ads131m08_adc(struct ads131m08 *chip);

#ifdef __cplusplus
}
#endif
#endif
