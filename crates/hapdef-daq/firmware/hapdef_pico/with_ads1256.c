/* Eight quarter bridges with a common reference arm on an ADS1256, 180 scans a second. */
#include "ads1256.h"
#include "pico_board.h"

enum { N = 8, AINCOM = 8 };
/* 2000 conversions a second, 1438 with the input changed each time; gain 2^6: 31 000 ue of range. */
static const struct ads1256_settings settings = {
    N,
    {ADS1256_MUX(0, AINCOM), ADS1256_MUX(1, AINCOM), ADS1256_MUX(2, AINCOM), ADS1256_MUX(3, AINCOM),
     ADS1256_MUX(4, AINCOM), ADS1256_MUX(5, AINCOM), ADS1256_MUX(6, AINCOM), ADS1256_MUX(7, AINCOM)},
    6, ADS1256_2000, 1
};
static const float GAUGE_FACTOR = 2.0f;

const unsigned converter_spi_hz = 1900000;
const unsigned converter_n_douts = 0;

static struct ads1256 chip;
static struct hdp1_channel channels[N];

struct adc converter(const struct adc_io *io, struct hdp1_hello *hello)
{
    unsigned i;

    for (i = 0; i < N; i++) {
        struct hdp1_channel c = {0, settings.log2_gain, 0, 0, 0, {'G', (char)('0' + i), 0, 0}};
        c.scale = ads1256_scale(&settings, GAUGE_FACTOR);
        c.skew_16ns = ads1256_skew_16ns(&settings, i);
        channels[i] = c;
    }
    hello->format = HDP1_I24;
    hello->scans = 1;
    hello->rate_mhz = ads1256_rate_mhz(&settings);
    hello->firmware = 1;
    hello->n_channels = N;
    hello->channels = channels;
    chip.io = *io;
    chip.settings = settings;
    return ads1256_adc(&chip);
}
