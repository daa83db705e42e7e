/* HX711: one bridge a chip, 24 bits, 10 or 80 a second; several chips on one clock line.
 *
 * begin takes 0.1 ms; poll reads all chips in 0.1 ms when each has a conversion. The clock line must
 * not stay high for 60 us, or the chips switch off: an interrupt as long as that is noticed, and the
 * reading is lost.
 */
#ifndef HX711_H
#define HX711_H

#include "converter.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Pulses of a reading: they choose input and gain of the next. */
enum hx711_input { HX711_A_128 = 25, HX711_B_32 = 26, HX711_A_64 = 27 };

struct hx711_settings {
    uint8_t n_chips;     /* up to ADC_MAX_CHANNELS */
    uint8_t input;       /* of enum hx711_input */
    uint16_t rate_hz;    /* 10 or 80: the level of the RATE pins */
};

struct hx711 {
    struct adc_io io;
    struct hx711_settings settings;
    uint32_t begun_us, read_us; /* begin, and the last reading */
    uint32_t dead;              /* a bit a chip: it did not answer once since begin */
    uint32_t silent;            /* a bit a chip: one of those, whose line was high since */
    uint8_t n_unsettled, is_late;
};

/* Microstrain per count of a quarter bridge on the chip's own supply. */
float hx711_scale(const struct hx711_settings *settings, float gauge_factor);

enum adc_result hx711_begin(struct hx711 *chips, const struct adc_io *io,
                            const struct hx711_settings *settings);

/* A chip that does not answer costs one wait of six conversions; then the others go on, and its
 * channel is faulty. When it answers again, but not within 2 s of begin, the result is ADC_WAS_RESET:
 * nobody knows what it made of the pulses that it heard, so all have to begin anew. */
enum adc_result hx711_poll(struct hx711 *chips, struct adc_scan *scan);

/* The chips for a board; io and settings in it have to be set. */
struct adc hx711_adc(struct hx711 *chips);

#ifdef __cplusplus
}
#endif
#endif
