/* Just enough of the Pico's SDK and of TinyUSB to compile and run hapdef_pico on the host. */
#ifndef FAKE_SDK_H
#define FAKE_SDK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef unsigned int uint;
enum { GPIO_IN = 0, GPIO_OUT = 1, GPIO_FUNC_SPI = 1 };
typedef enum { SPI_CPOL_0, SPI_CPOL_1 } spi_cpol_t;
typedef enum { SPI_CPHA_0, SPI_CPHA_1 } spi_cpha_t;
typedef enum { SPI_LSB_FIRST, SPI_MSB_FIRST } spi_order_t;
typedef struct spi_inst spi_inst_t;
extern spi_inst_t *const spi0;
typedef struct {
    uint8_t id[8];
} pico_unique_board_id_t;

void gpio_init(uint pin);
void gpio_set_dir(uint pin, bool is_output);
void gpio_put(uint pin, bool level);
bool gpio_get(uint pin);
void gpio_pull_up(uint pin);
void gpio_set_function(uint pin, int function);

uint spi_init(spi_inst_t *spi, uint hz);
void spi_set_format(spi_inst_t *spi, uint bits, spi_cpol_t cpol, spi_cpha_t cpha,
                    spi_order_t order);
int spi_write_read_blocking(spi_inst_t *spi, const uint8_t *out, uint8_t *in, size_t n);

uint32_t time_us_32(void);
void busy_wait_us_32(uint32_t us);
uint32_t get_rand_32(void);
void pico_get_unique_board_id(pico_unique_board_id_t *id);

bool tusb_init(void);
void tud_task(void);
bool tud_cdc_connected(void);
uint32_t tud_cdc_write_available(void);
uint32_t tud_cdc_write(const void *bytes, uint32_t n);
uint32_t tud_cdc_write_flush(void);
bool tud_cdc_write_clear(void);
uint32_t tud_cdc_available(void);
int32_t tud_cdc_read_char(void);

#endif
