/* ADS1256: eight inputs one after another, 24 bits, by SPI. Data sheet: TI SBAS288K.
 *
 * Clock 7.68 MHz. begin takes the self-calibration, a few ms at 1000 a second and faster, and 60 ms
 * at most more; poll takes 70 us. Nothing on the wire has a checksum: the registers are read again
 * once a second instead.
 */
#ifndef ADS1256_H
#define ADS1256_H

#include "converter.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ADS1256_MAX_INPUTS 8u
/* CPOL 0, CPHA 1; a quarter of the chip's clock. */
#define ADS1256_SPI_MODE 1
#define ADS1256_SPI_MAX_HZ 1920000u
/* Input a against input b; 8 is AINCOM. */
#define ADS1256_MUX(a, b) ((uint8_t)((a) << 4 | (b)))

/* Conversions a second; with the input changed each time there are fewer, ads1256_rate_mhz. */
enum ads1256_rate {
    ADS1256_30000, ADS1256_15000, ADS1256_7500, ADS1256_3750, ADS1256_2000, ADS1256_1000,
    ADS1256_500, ADS1256_100, ADS1256_60, ADS1256_50, ADS1256_30, ADS1256_25, ADS1256_15,
    ADS1256_10, ADS1256_5, ADS1256_N_RATES
};

struct ads1256_settings {
    uint8_t n_inputs;
    uint8_t mux[ADS1256_MAX_INPUTS];
    uint8_t log2_gain; /* 0 to 6 */
    uint8_t rate;      /* of enum ads1256_rate */
    uint8_t buffers;   /* the input buffer: for bridges, up to AVDD - 2 V */
};

struct ads1256 {
    struct adc_io io;
    struct ads1256_settings settings;
    struct adc_scan scan; /* as far as it is */
    uint32_t started_us;  /* the conversion under way */
    uint32_t checked_us;
    uint8_t input;        /* that is converted now */
};

/* Scans of all inputs per 1000 s. */
uint32_t ads1256_rate_mhz(const struct ads1256_settings *settings);

/* From one input's sample instant to the next one's, in 16 ns; no more than 16 bits hold, 1.05 ms. */
uint16_t ads1256_skew_16ns(const struct ads1256_settings *settings, unsigned input);

/* Microstrain per count of a quarter bridge whose supply is twice VREF. */
float ads1256_scale(const struct ads1256_settings *settings, float gauge_factor);

enum adc_result ads1256_begin(struct ads1256 *chip, const struct adc_io *io,
                              const struct ads1256_settings *settings);

enum adc_result ads1256_poll(struct ads1256 *chip, struct adc_scan *scan);

/* The chip for a board; io and settings in it have to be set. */
struct adc ads1256_adc(struct ads1256 *chip);

#ifdef __cplusplus
}
#endif
#endif
