/* Ten quarter bridges on ten HX711 with a common clock line at 80 Hz. */
#include "hx711.h"
#include "pico_board.h"

enum { N = 10 };
static const struct hx711_settings settings = {N, HX711_A_128, 80};
static const float GAUGE_FACTOR = 2.0f;

const unsigned converter_spi_hz = 0;
const unsigned converter_n_douts = N;

static struct hx711 chips;
static struct hdp1_channel channels[N];

struct adc converter(const struct adc_io *io, struct hdp1_hello *hello)
{
    unsigned i;

    for (i = 0; i < N; i++) {
        struct hdp1_channel c = {0, 7, 0, 0, 0, {'G', (char)('0' + i), 0, 0}};
        c.scale = hx711_scale(&settings, GAUGE_FACTOR);
        channels[i] = c;
    }
    hello->format = HDP1_I24;
    hello->scans = 1;
    hello->rate_mhz = 1000u * settings.rate_hz;
    hello->firmware = 1;
    hello->n_channels = N;
    hello->channels = channels;
    chips.io = *io;
    chips.settings = settings;
    return hx711_adc(&chips);
}
