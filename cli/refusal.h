/** @file
 * Options that do not go together, or do nothing to what they are given for. What people typed is refused; what stands
 * in the file of defaults gives way to it.
 */
#ifndef CLI_REFUSAL_H
#define CLI_REFUSAL_H
#include "command.h"

/**
 * What failed because of options: the first of them that the file of defaults gave is to be left out.
 *
 * options   as they are typed, without dashes, with commas between: those of a conflict, in the order in which they
 *           give way
 * Returns   st
 */
vv_status cli_refused(const cli_command *command, const char *options, vv_status st);
/** The same of all options of a class: which of them it was about is not known. */
vv_status cli_refused_class(const cli_command *command, const vv_class *cls, vv_status st);
/** Parameters of an operation that are set and do nothing, as their rows say (vv_property.when): VV_E_ARGUMENT.
 * data: "labels" or "values"; NULL: neither. */
vv_status cli_refuse_idle(const cli_command *command, const vv_object *params, const char *data);
/** After a failure: leaves out what is to be, and says so (-v). True: something was left out, and the options of its
 * class are made anew, so that what failed should be tried again. */
bool cli_refusal_gives_way(cli_command *command);
#endif
