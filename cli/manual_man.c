#include "args.h"
#include "manual.h"
#include "options.h"
#include "usage.h"
#include <volvis/version.h>

/* Text as roff has it: no control lines, no escapes, hyphens that can be copied. */
static void add(vvi_text *out, const char *s)
{
    if (*s == '.' || *s == '\'')
        vvi_text_add(out, "\\&");
    for (; *s; s++) {
        if (*s == '\\')
            vvi_text_add(out, "\\e");
        else if (*s == '-')
            vvi_text_add(out, "\\-");
        else
            vvi_text_add_n(out, s, 1);
    }
}

static void add_heading(vvi_text *out, const char *name, const char *doc)
{
    vvi_text_printf(out, ".TH %s 1 \"\" \"VolVis %s\" \"VolVis manual\"\n.SH NAME\n", name, vv_version());
    add(out, name);
    vvi_text_add(out, " \\- ");
    add(out, doc);
    vvi_text_add(out, "\n");
}

static void add_entry(vvi_text *out, const char *left, const char *right)
{
    vvi_text_add(out, ".TP\n.B ");
    add(out, left);
    vvi_text_add(out, "\n");
    add(out, right);
    vvi_text_add(out, "\n");
}

/* title NULL: it goes on under the last one. */
static void add_class(vvi_text *out, const char *title, const vv_class *cls)
{
    if (title)
        vvi_text_printf(out, ".SH %s\n", title);
    for (const vv_property *row = cls->properties; row->name; row++) {
        vvi_text left = {0}, right = {0};
        if (!cli_option_is_listed(row))
            continue;
        cli_usage_option(&left, row);
        cli_usage_option_doc(&right, row);
        add_entry(out, left.bad ? "" : left.s, right.bad ? "" : right.s);
        vvi_text_free(&left);
        vvi_text_free(&right);
    }
}

static void add_exit_codes(vvi_text *out)
{
    static const char *const codes[][2] = {
        {"0", "done"},
        {"1", "could not be done"},
        {"2", "the command line is wrong"},
        {"3", "an input cannot be read"},
        {"4", "the memory limit would be exceeded"},
        {"5", "the output cannot be written"},
        {"6", "a comparison differs"},
        {"7", "done in part: an input is damaged, and a warning names what is missing"},
        {"75", "stopped, and the same command goes on from where it was"},
        {"130", "interrupted: whatever was complete is kept"},
    };
    vvi_text_add(out, ".SH EXIT STATUS\n");
    for (size_t i = 0; i < sizeof codes / sizeof codes[0]; i++)
        vvi_text_printf(out, ".TP\n.B %s\n%s\n", codes[i][0], codes[i][1]);
}

static const char *title_of(const vv_class *cls)
{
    return cls == &cli_common_class || cls == &cli_common_plain_class ? "OPTIONS OF EVERY VERB"
           : cli_is_reading(cls)                                      ? "OPTIONS OF READING"
           : cls == &cli_writing_class                                ? "OPTIONS OF WRITING"
                                                                      : "OPTIONS";
}

void cli_manual_verb(vvi_text *out, const cli_verb *verb)
{
    vvi_text name = {0}, usage = {0};
    const vv_class *cls;
    const char *example;
    vvi_text_printf(&name, "volvis-%s", verb->name);
    cli_usage_line(&usage, verb);
    add_heading(out, name.bad ? "" : name.s, verb->doc);
    vvi_text_add(out, ".SH SYNOPSIS\n.B ");
    add(out, usage.bad ? "" : usage.s);
    vvi_text_add(out, "\n");
    if (verb->about) {
        vvi_text_add(out, ".SH DESCRIPTION\n");
        add(out, verb->about);
        vvi_text_add(out, "\n");
    }
    cli_usage_inputs(out, verb, ".SH INPUTS\n", add_entry);
    const char *last = NULL;
    for (size_t i = 0; (cls = cli_usage_shown(verb, i)); i++) {
        const char *title = title_of(cls);
        if (!cls->properties->name)
            continue;
        add_class(out, title == last ? NULL : title, cls);
        last = title;
    }
    vvi_text_add(out, ".SH EXAMPLES\n.nf\n");
    for (size_t i = 0; (example = cli_usage_example(verb, i)); i++) {
        add(out, example);
        vvi_text_add(out, "\n");
    }
    vvi_text_add(out, ".fi\n");
    add_exit_codes(out);
    vvi_text_add(out, ".SH SEE ALSO\n.BR volvis (1)\n");
    vvi_text_free(&name);
    vvi_text_free(&usage);
}

void cli_manual_program(vvi_text *out, const vv_registry *registry)
{
    cli_verb verb;
    add_heading(out, "volvis", "see, measure and change volumes");
    vvi_text_add(out, ".SH SYNOPSIS\n.B volvis\n.I VERB\n[options] INPUT... [\\-o OUTPUT]\n.SH VERBS\n");
    for (size_t i = 0; cli_verb_nth(&verb, registry, i); i++) {
        if (verb.hidden)
            continue;
        vvi_text_printf(out, ".TP\n.BR volvis\\-%s (1)\n", verb.name);
        add(out, verb.doc);
        vvi_text_add(out, "\n");
    }
    add_class(out, "OPTIONS OF EVERY VERB", &cli_common_class);
    vvi_text_add(out, ".SH ENVIRONMENT\n"
                      ".TP\n.B VOLVIS_THREADS\nhow many threads work, where \\-\\-threads does not say\n"
                      ".TP\n.B VOLVIS_MEMORY\nlimit on memory, where \\-\\-memory does not say\n"
                      ".TP\n.B VOLVIS_LIMITS\nlimits on what comes from files, as in voxels=1000000,files=100\n"
                      ".TP\n.B VOLVIS_CPU\nthe instruction set to use: base, avx2, avx512, neon\n"
                      ".TP\n.B VOLVIS_DEFAULTS\nthe file of defaults, or none\n"
                      ".TP\n.B NO_COLOR\nno colour in messages\n");
    vvi_text_add(out,
                 ".SH FILES\n.TP\n.B ~/.config/volvis/defaults\n"
                 "Options that hold where the command line does not say otherwise ($XDG_CONFIG_HOME takes the place "
                 "of ~/.config). A line is a verb and its options, as they are typed; a line without a verb holds "
                 "for every verb; # begins a comment line:\n"
                 ".nf\n\n\\-\\-threads 4\nrender \\-\\-size 1024 \\-\\-background white\n\n.fi\n"
                 "An option on the command line replaces that of the file; \\-\\-set and \\-\\-limit add to it. "
                 "What does not go together with an option on the command line, or does nothing to the input, is "
                 "left out. "
                 "Scenes and pictures that VolVis made are rendered as they are: options about the picture do not "
                 "hold for them. \\-\\-no\\-defaults leaves the file out, and \\-v says what was taken from it.\n");
    add_exit_codes(out);
}
