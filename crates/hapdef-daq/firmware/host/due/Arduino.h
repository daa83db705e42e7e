/* Just enough of the Arduino Due's core to compile and run the sketch on the host. */
#ifndef FAKE_ARDUINO_H
#define FAKE_ARDUINO_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { A0 = 54, CDC_TX = 3, ID_TRNG = 41 };
enum { UOTGHS_DEVEPTISR_TXINI = 1, TRNG_CR_ENABLE = 1, TRNG_ISR_DATRDY = 1 };
#define TRNG_CR_KEY(key) ((key) << 8)

#define EEFC_FCR_FKEY(key) ((key) << 24)
#define EEFC_FCR_FCMD(command) (command)
enum { EFC_FCMD_STUI = 14, EFC_FCMD_SPUI = 15, EEFC_FSR_FRDY = 1 };

/* Ready until a command is given, and again when it is read for the second time. */
struct FakeFlashState {
    uint32_t n_reads;
    operator uint32_t() { return n_reads++ & 1u; }
};
struct FakeFlash {
    uint32_t EEFC_FCR;
    FakeFlashState EEFC_FSR;
};
extern FakeFlash *EFC1;
extern const uint8_t fake_uid[16];
#define IFLASH1_ADDR fake_uid

struct FakeUsb {
    uint32_t UOTGHS_DEVEPTISR[10];
};
struct FakeTrng {
    uint32_t TRNG_CR, TRNG_ISR, TRNG_ODATA;
};
extern FakeUsb *UOTGHS;
extern FakeTrng *TRNG;

struct FakeSerial {
    void begin(uint32_t) {}
    bool dtr();
    int available();
    int read();
    size_t write(const uint8_t *bytes, size_t n);
};
extern FakeSerial SerialUSB;

uint32_t micros();
int analogRead(int pin);
inline void analogReadResolution(int) {}
inline void noInterrupts() {}
inline void interrupts() {}
inline void pmc_enable_periph_clk(int) {}

#endif
