#include "options.h"

static const vv_property word_rows[] = {
    {VV_PROP(cli_word, text), .kind = VV_KIND_STRING, .doc = "one of the values"},
    {0},
};

const vv_class cli_word_class = {
    .name = "word",
    .doc = "one value of an option that may be repeated",
    .size = sizeof(cli_word),
    .properties = word_rows,
};

const char *cli_word_nth(const vv_collection *words, size_t index)
{
    if (!words || index >= words->n)
        return NULL;
    return ((const cli_word *)(const void *)words->entry[index].object)->text;
}

static const char *const progress_names[] = {"auto", "bar", "json", "none", NULL};

/* The first of them is of verbs with a World alone: cli_common_plain_class. */
static const vv_property common_rows[] = {
    {VV_PROP(cli_common, set), .kind = VV_KIND_LIST, .cls = &cli_word_class, .unit = "PATH=VALUE",
     .table = "properties",
     .doc = "set a property of the World; * stands for all of a map or list, a number for one of them, as in "
            "volumes.*.visible=false or volumes.0.visible; may be repeated"},
    {VV_PROP(cli_common, output), .kind = VV_KIND_PATH, .letter = 'o',
     .doc =
         "where the result goes; the suffix chooses the format, '-' is standard output; for info, render, convert and "
         "operations, '{stem}.png' makes one result for each input, named after it"},
    {VV_PROP(cli_common, json), .kind = VV_KIND_BOOL,
     .doc = "print the result as one JSON document on standard output"},
    {VV_PROP(cli_common, threads), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 256, .def = 1,
     .automatic = "VOLVIS_THREADS, else all cores", .doc = "number of threads to use"},
    {VV_PROP(cli_common, memory), .kind = VV_KIND_F64, .quantity = VV_Q_BYTES, .limited = true, .min = 1, .max = 1e18,
     .def = 1, .automatic = "VOLVIS_MEMORY, else half of the memory of the machine or its control group",
     .doc = "limit on memory use, as in 8G or 500M; mapped files belong to the system's cache: they show in the "
            "resident size, but do not count"},
    {VV_PROP(cli_common, limit), .kind = VV_KIND_LIST, .cls = &cli_word_class, .unit = "NAME=VALUE",
     .automatic = "VOLVIS_LIMITS, else the defaults",
     .doc = "a limit on data from files, as listed by 'volvis doctor --limits'; may be repeated"},
    {VV_PROP(cli_common, progress), .kind = VV_KIND_ENUM, .names = progress_names,
     .doc = "how progress is shown: as a bar on a terminal and plain lines in a log, as one JSON object per line, or "
            "not at all; with json the last line of each stage has done = total unless the work failed"},
    {VV_PROP(cli_common, dry_run), .kind = VV_KIND_BOOL, .doc = "print what would be read, made and needed, and stop"},
    {VV_PROP(cli_common, overwrite), .kind = VV_KIND_BOOL,
     .doc = "let the output replace one of the inputs, or a file that was named without -o"},
    {VV_PROP(cli_common, allow_outside), .kind = VV_KIND_BOOL,
     .doc = "allow data files outside the folder of the header that names them"},
    {VV_PROP(cli_common, safe), .kind = VV_KIND_BOOL, .automatic = "only HDF5 and formats built on it",
     .doc =
         "read volumes and meshes in a separate, confined process: for files from people you do not trust; scenes are "
         "still read in the program"},
    {VV_PROP(cli_common, defaults), .kind = VV_KIND_BOOL, .def = 1,
     .doc = "the options in ~/.config/volvis/defaults ('volvis man' describes the file)"},
    {VV_PROP(cli_common, quiet), .kind = VV_KIND_BOOL, .letter = 'q',
     .doc = "print no progress, no warnings and no line about the file that was made"},
    {VV_PROP(cli_common, verbose), .kind = VV_KIND_BOOL, .letter = 'v', .doc = "print what was chosen and why"},
    {VV_PROP(cli_common, help), .kind = VV_KIND_BOOL, .letter = 'h', .doc = "show this help"},
    {0},
};

const vv_class cli_common_class = {
    .name = "common",
    .doc = "options of every verb",
    .size = sizeof(cli_common),
    .properties = common_rows,
};

const vv_class cli_common_plain_class = {
    .name = "common",
    .doc = "options of every verb",
    .size = sizeof(cli_common),
    .properties = common_rows + 1,
};

/* The first of them is not of operations that have one of that name: cli_reading_rest_class. */
static const vv_property reading_rows[] = {
    {VV_PROP(cli_reading, missing), .kind = VV_KIND_STRING, .unit = "VALUE,...|none",
     .automatic = "what the file says, else one value far from all others that many samples have, such as -9999",
     .doc = "values that mean 'not measured': they are left out of pictures, figures and results, and written as NaN; "
            "none: every value counts"},
    {VV_PROP(cli_reading, frame), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 1e15,
     .doc = "time step to read, from 0; the same as FILE@N"},
    {VV_PROP(cli_reading, part), .kind = VV_KIND_STRING, .unit = "NAME", .automatic = "chosen by the reader",
     .doc =
         "data set of a file or folder that holds several, as listed by 'volvis info', or axes of a NumPy array, as in "
         "zyx (--axes zyx is the same); the same as FILE:NAME"},
    {VV_PROP(cli_reading, raw), .kind = VV_KIND_STRING, .unit = "XxYxZ,TYPE[,...]",
     .automatic = "from a name such as engine_256x256x128_uint8.raw",
     .doc = "layout of a file without a header: 256x256x128,u8[,spacing=1x1x1.4][,big][,skip=N]"},
    {VV_PROP(cli_reading, input_format), .kind = VV_KIND_STRING, .unit = "NAME", .table = "formats",
     .automatic = "from the contents, then from the suffix", .doc = "format of the input"},
    {0},
};

const vv_class cli_reading_class = {
    .name = "reading",
    .doc = "options of verbs that read data",
    .size = sizeof(cli_reading),
    .properties = reading_rows,
};

const vv_class cli_reading_rest_class = {
    .name = "reading",
    .doc = "options of verbs that read data",
    .size = sizeof(cli_reading),
    .properties = reading_rows + 1,
};

bool cli_is_reading(const vv_class *cls)
{
    return cls == &cli_reading_class || cls == &cli_reading_rest_class;
}

static const vv_property writing_rows[] = {
    {VV_PROP(cli_writing, output_format), .kind = VV_KIND_STRING, .unit = "NAME", .table = "formats",
     .automatic = "from the suffix of the output", .doc = "format of the output"},
    {VV_PROP(cli_writing, encoding), .kind = VV_KIND_STRING, .unit = "NAME", .table = "encodings",
     .automatic = "the format's first",
     .doc = "how samples are coded in the output: raw, gzip, ... ('volvis formats' lists them)"},
    {VV_PROP(cli_writing, level), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 9, .def = 1,
     .automatic = "the encoding's own", .doc = "of compression, from 1 (fast) to 9 (small)"},
    {VV_PROP(cli_writing, big_endian), .kind = VV_KIND_BOOL, .doc = "most significant byte first"},
    {VV_PROP(cli_writing, stored), .kind = VV_KIND_BOOL,
     .doc = "write numbers as they are stored, with their scale and offset, which other programs may not know, instead "
            "of values (NIfTI always does, since all programs know its scale)"},
    {0},
};

const vv_class cli_writing_class = {
    .name = "writing",
    .doc = "options of verbs that write data",
    .size = sizeof(cli_writing),
    .properties = writing_rows,
};

static const vv_property timing_rows[] = {
    {VV_PROP(cli_timing, repeat), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 1000,
     .doc = "repeat the work this many times, and report the median time"},
    {0},
};

const vv_class cli_timing_class = {
    .name = "timing",
    .doc = "timing",
    .size = sizeof(cli_timing),
    .properties = timing_rows,
};
