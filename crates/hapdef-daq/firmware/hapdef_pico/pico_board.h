/* What main.c needs from the file of a converter. */
#ifndef PICO_BOARD_H
#define PICO_BOARD_H

#include "board.h"

/* SPI's clock, 0 for a converter without SPI. Its mode is 1 for all. */
extern const unsigned converter_spi_hz;
/* Data lines of chips without SPI. */
extern const unsigned converter_n_douts;

/* The converter, and what HELLO says of it; the board's identity is filled in by main.c. */
struct adc converter(const struct adc_io *io, struct hdp1_hello *hello);

#endif
