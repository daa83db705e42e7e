/* Runs the sketch on the host: 5 s of its time. From second 2 to 3 the host is away without having
 * closed the port; from 4.1 to 4.3 the port is closed. */
#include "Arduino.h"

#include <stdio.h>
#include <stdlib.h>

#include "../../hapdef_due/hapdef_due.ino"

static FakeUsb usb;
static FakeTrng trng = {0, TRNG_ISR_DATRDY, 77};
FakeUsb *UOTGHS = &usb;
FakeTrng *TRNG = &trng;
static FakeFlash flash = {0, {0}};
FakeFlash *EFC1 = &flash;
const uint8_t fake_uid[16] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
FakeSerial SerialUSB;
static uint32_t us = 0xffffffffu - 2500000u; /* micros() wraps on the way. */
static uint32_t started;

uint32_t micros() { return us; }

static bool is_between(uint32_t from_ms, uint32_t to_ms)
{
    uint32_t ms = (us - started) / 1000u;
    return ms >= from_ms && ms < to_ms;
}

static bool is_away() { return is_between(2000, 3000); }

int analogRead(int pin)
{
    us += 4;
    return 100 * (pin - A0) + 8;
}

bool FakeSerial::dtr() { return !is_between(4100, 4300); }

/* What the host said before: on standard input. */
int FakeSerial::available()
{
    int byte = getchar();
    if (byte == EOF)
        return 0;
    ungetc(byte, stdin);
    return 1;
}

int FakeSerial::read() { return getchar(); }

size_t FakeSerial::write(const uint8_t *bytes, size_t n)
{
    if (is_away() || !dtr()) {
        fprintf(stderr, "the core's write would block for ever here\n");
        exit(1);
    }
    return fwrite(bytes, 1, n, stdout);
}

int main()
{
    started = us;
    setup();
    while (us - started < 5000000u) {
        us += 20;
        usb.UOTGHS_DEVEPTISR[CDC_TX] = is_away() ? 0 : UOTGHS_DEVEPTISR_TXINI;
        loop();
    }
    return 0;
}
