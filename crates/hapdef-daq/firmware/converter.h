/* What a driver of converters needs from the board, and what it gives.
 *
 * Drivers are C99 without heap, library or registers of a controller. Nothing in them waits longer
 * than its header says: a chip that is dead ends in one of the errors below.
 */
#ifndef CONVERTER_H
#define CONVERTER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ADC_MAX_CHANNELS 16u
/* Ends of 24 bits. */
#define ADC_HIGHEST 0x7fffff
#define ADC_LOWEST (-0x800000)

enum adc_pin {
    ADC_CS = 0,    /* chip select, low when selected */
    ADC_RESET = 1, /* reset, low when active */
    ADC_DRDY = 2,  /* data ready, low when there is */
    ADC_SCK = 3,   /* clock of chips without SPI */
    ADC_DOUT = 4   /* data of the first such chip; those of the others follow */
};

/* The board, as a driver uses it. */
struct adc_io {
    void *context;
    /* Exchanges n bytes by SPI, most significant bit first, in the mode that the driver names. */
    void (*exchange)(void *context, const uint8_t *out, uint8_t *in, size_t n);
    void (*write)(void *context, unsigned pin, int level);
    int (*read)(void *context, unsigned pin);
    void (*delay_us)(void *context, uint32_t us);
    /* Microseconds since some moment; wraps at 2^32. */
    uint32_t (*now_us)(void *context);
};

enum adc_result {
    ADC_OK = 0,
    ADC_PENDING,      /* no scan yet: poll again */
    ADC_SCAN,         /* a scan */
    ADC_BAD_SETTINGS, /* errors from here on */
    ADC_NO_CHIP,      /* the data line stays at one level */
    ADC_OTHER_CHIP,   /* another chip answers, or nonsense */
    ADC_BAD_REGISTER, /* a register does not hold what was written to it */
    ADC_BAD_CRC,      /* a frame was damaged; the scan in it is lost */
    ADC_NOT_READY,    /* data ready never comes, or never goes */
    ADC_WAS_RESET     /* the chip has lost its settings, or may be out of step */
};

/* A reading of all channels. */
struct adc_scan {
    int32_t code[ADC_MAX_CHANNELS];
    uint32_t t_us;      /* sample instant, by now_us of adc_io */
    uint32_t saturated; /* a bit a channel: at the end of its range */
    uint32_t faulty;    /* a bit a channel: does not answer; its code is ADC_LOWEST */
    uint8_t is_late;    /* scans are missing in front of it */
};

/* A converter, as the board uses it. */
struct adc {
    const char *name;
    void *chip;
    /* Resets the chip and sets it up: ADC_OK, or an error. */
    enum adc_result (*begin)(void *chip);
    /* ADC_SCAN, ADC_PENDING, or an error. Returns at once. */
    enum adc_result (*poll)(void *chip, struct adc_scan *scan);
};

/* A result in words. */
const char *adc_words(enum adc_result result);

/* Two's complement of 24 bits, most significant byte first. */
int32_t adc_code(const uint8_t bytes[3]);

/* Puts a channel's code into a scan, and whether it is at the end of its range. */
void adc_put(struct adc_scan *scan, unsigned channel, int32_t code);

/* Microstrain per count of a quarter bridge, from the input of `counts` in volts per volt of the
 * bridge's supply: a gauge gives a quarter of its gauge factor times its strain. */
float adc_quarter_bridge(float full_scale, float counts, float gauge_factor);

#ifdef __cplusplus
}
#endif
#endif
