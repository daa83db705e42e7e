/* What the drivers share; see converter.h. */
#include "converter.h"

const char *adc_words(enum adc_result result)
{
    switch (result) {
    case ADC_BAD_SETTINGS: return "settings out of range";
    case ADC_NO_CHIP: return "no chip answers: power, SCLK, DIN, DOUT, CS";
    case ADC_OTHER_CHIP: return "another chip answers, or nonsense";
    case ADC_BAD_REGISTER: return "a register does not keep its value";
    case ADC_BAD_CRC: return "frames are damaged: wires, SCLK too fast";
    case ADC_NOT_READY: return "no data: DRDY, clock of the chip";
    case ADC_WAS_RESET: return "was reset, or is out of step: power, wires";
    default: return "works";
    }
}

int32_t adc_code(const uint8_t bytes[3])
{
    int32_t code = (int32_t)((uint32_t)bytes[0] << 16 | (uint32_t)bytes[1] << 8 | bytes[2]);

    return code > ADC_HIGHEST ? code - 0x1000000 : code;
}

void adc_put(struct adc_scan *scan, unsigned channel, int32_t code)
{
    scan->code[channel] = code;
    if (code >= ADC_HIGHEST || code <= ADC_LOWEST)
        scan->saturated |= (uint32_t)1 << channel;
}

float adc_quarter_bridge(float full_scale, float counts, float gauge_factor)
{
    return 4.0e6f * full_scale / (gauge_factor * counts);
}
