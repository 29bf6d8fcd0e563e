/** @file
 * What the work of a run has found (vv_job_finding()), as part of its report.
 */
#ifndef CLI_FINDINGS_H
#define CLI_FINDINGS_H
#include "command.h"

/** Figures as JSON, phrases as text: " 3 pieces became 2, ... ;", notes behind the first input's name. */
void cli_findings_report(cli_command *command);
/** "warnings" as JSON: those of the library in this run. */
void cli_findings_warnings(cli_command *command);
#endif
