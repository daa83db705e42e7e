/* Fakes of converters, written from their data sheets and not from the drivers.
 *
 * A clock that only the firmware's own actions move; a chip behind pins and SPI; what the data sheet
 * forbids ends the program with code 3 and a line on standard error. Each conversion is a line on
 * standard error as well: "conversion CHANNEL STRAIN CODE".
 */
#ifndef FAKE_H
#define FAKE_H

#include <stddef.h>
#include <stdint.h>

enum fake_pin { FAKE_CS, FAKE_RESET, FAKE_DRDY, FAKE_SCK, FAKE_DOUT };
enum { FAKE_MAX_CHIPS = 16 };

struct fake_chip {
    const char *name;
    uint32_t max_hz;
    /* Does what has come due by fake_ns. */
    void (*advance)(void);
    void (*pin)(unsigned pin, int level);
    int (*level)(unsigned pin);
    /* Eight clocks of SPI, which begin at fake_ns. */
    uint8_t (*exchange)(uint8_t out);
};

extern const struct fake_chip fake_ads131m08, fake_ads1256, fake_hx711;

/* Nanoseconds since the start. */
extern uint64_t fake_ns;

/* Puts a chip on the bench, with a fault to play: see fake_has. 0 if there is no such chip. */
int fake_begin(const char *chip, const char *fault);

/* Whether this fault is played: all the time, or (fake_has_now) from 2 to 2.2 s. */
int fake_has(const char *fault);
int fake_has_now(const char *fault);

/* What the firmware does. */
void fake_spend(uint64_t ns);
void fake_write(unsigned pin, int level);
int fake_read(unsigned pin);
/* SPI at that clock, in mode 0 to 3. */
void fake_exchange(const uint8_t *out, uint8_t *in, size_t n, uint32_t hz, int mode);

/* What a gauge of channel feels in its n-th conversion, in microstrain. */
double fake_strain_ue(unsigned channel, uint32_t n);

/* The code of a fraction of the full scale: 24 bits, clipped at its ends. */
int32_t fake_code(double fraction, double counts);

void fake_tell(unsigned channel, double strain_ue, int32_t code);
void fake_forbidden(const char *format, ...);

#endif
