/* Eight quarter bridges on an ADS131M08 at 1 kHz. */
#include "ads131m08.h"
#include "pico_board.h"

/* Ratio 2^12: 1000 scans a second. Gain 2^5: 30 000 ue of range, and a higher gain has no less noise. */
static const struct ads131m08_settings settings = {12, 5, 1, 0};
static const float GAUGE_FACTOR = 2.0f;

const unsigned converter_spi_hz = 8000000;
const unsigned converter_n_douts = 0;

static struct ads131m08 chip;
static struct hdp1_channel channels[ADS131M08_CHANNELS];

struct adc converter(const struct adc_io *io, struct hdp1_hello *hello)
{
    unsigned i;

    for (i = 0; i < ADS131M08_CHANNELS; i++) {
        struct hdp1_channel c = {0, settings.log2_gain, 0, 0, 0, {'G', (char)('0' + i), 0, 0}};
        c.scale = ads131m08_scale(&settings, GAUGE_FACTOR);
        channels[i] = c;
    }
    hello->format = HDP1_I24;
    hello->scans = 1;
    hello->rate_mhz = ads131m08_rate_mhz(&settings);
    hello->firmware = 1;
    hello->n_channels = ADS131M08_CHANNELS;
    hello->channels = channels;
    chip.io = *io;
    chip.settings = settings;
    return ads131m08_adc(&chip);
}
