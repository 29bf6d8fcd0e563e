#include "core/oklab.h"
#include <math.h>

void vvi_oklab_to_linear(double rgb[3], const double lab[3])
{
    static const double to_lms[3][3] = {
        {1, 0.3963377774, 0.2158037573}, {1, -0.1055613458, -0.0638541728}, {1, -0.0894841775, -1.2914855480}};
    static const double to_rgb[3][3] = {{4.0767416621, -3.3077115913, 0.2309699292},
                                        {-1.2684380046, 2.6097574011, -0.3413193965},
                                        {-0.0041960863, -0.7034186147, 1.7076147010}};
    double lms[3];
    for (int i = 0; i < 3; i++) {
        const double root = to_lms[i][0] * lab[0] + to_lms[i][1] * lab[1] + to_lms[i][2] * lab[2];
        lms[i] = root * root * root;
    }
    for (int i = 0; i < 3; i++)
        rgb[i] = fmin(fmax(to_rgb[i][0] * lms[0] + to_rgb[i][1] * lms[1] + to_rgb[i][2] * lms[2], 0), 1);
}
