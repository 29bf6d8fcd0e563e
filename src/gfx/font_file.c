/* Where a font comes from. Liberation Sans has the measures of Helvetica and Arial, which journals ask for. */
#include "gfx/font_file.h"
#include "config.h"
#include "core/memory.h"
#include <stdlib.h>
#include <unistd.h>

#if VV_HAVE_FONTCONFIG
#include <fontconfig/fontconfig.h>

static FcPattern *wanted(void)
{
    static const char *const families[] = {"Liberation Sans", "Arimo",     "Arial", "Helvetica",
                                           "DejaVu Sans",     "Noto Sans", "Lato",  "sans-serif"};
    FcPattern *pattern = FcPatternCreate();
    for (size_t i = 0; pattern && i < sizeof families / sizeof *families; i++)
        FcPatternAddString(pattern, FC_FAMILY, (const FcChar8 *)families[i]);
    if (pattern) {
        FcPatternAddBool(pattern, FC_SCALABLE, FcTrue);
        FcPatternAddBool(pattern, FC_VARIABLE, FcFalse);
    }
    return pattern;
}

/* NULL: there is none. */
static char *ask_fontconfig(void)
{
    char *path = NULL;
    FcChar8 *file;
    FcResult result;
    FcConfig *config = FcInitLoadConfigAndFonts();
    FcPattern *pattern = config ? wanted() : NULL;
    if (pattern) {
        FcConfigSubstitute(config, pattern, FcMatchPattern);
        FcDefaultSubstitute(pattern);
        FcPattern *match = FcFontMatch(config, pattern, &result);
        if (match && FcPatternGetString(match, FC_FILE, 0, &file) == FcResultMatch)
            path = vvi_strdup((const char *)file);
        if (match)
            FcPatternDestroy(match);
        FcPatternDestroy(pattern);
    }
    if (config)
        FcConfigDestroy(config);
    return path;
}
#else
static char *ask_fontconfig(void)
{
    return NULL;
}
#endif

/* Where Debian and its like put them: looked at first, for fontconfig takes longer to start than a picture to draw. */
static const char *const usual[] = {
    "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
    "/usr/share/fonts/truetype/liberation2/LiberationSans-Regular.ttf",
};

static char *find(void)
{
    for (size_t i = 0; i < sizeof usual / sizeof *usual; i++)
        if (access(usual[i], R_OK) == 0)
            return vvi_strdup(usual[i]);
    return ask_fontconfig();
}

vv_status vvi_font_find(char **out, const char *path)
{
    const char *asked = path ? path : getenv("VOLVIS_FONT");
    *out = asked && *asked ? vvi_strdup(asked) : find();
    if (*out)
        return VV_OK;
    if (asked && *asked)
        return vv_fail(VV_E_MEMORY, "there is no memory for the name of a font");
    return vv_fail(VV_E_NOT_FOUND, "no font was found: install fonts-liberation, or set VOLVIS_FONT to a .ttf file");
}
