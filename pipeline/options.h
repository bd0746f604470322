/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_OPTIONS_H
#define FEWRAY_PIPELINE_OPTIONS_H

/* Command lines: each subcommand describes its options in a table; parsing, checking and --help
 * follow from it. */

#include <stdbool.h>
#include <stdint.h>

enum option_kind {
    OPTION_FLAG,   /* bool */
    OPTION_TEXT,   /* const char * */
    OPTION_INT,    /* int, least..most */
    OPTION_SEED,   /* uint64_t */
    OPTION_FLOAT,  /* float, least..most */
    OPTION_SIZE,   /* size_t, bytes; K, M, G behind the number: times 1024, 1024^2, 1024^3 */
    OPTION_TIME,   /* double, seconds > 0: "500ms", "5s", "2m", or a number of seconds */
    OPTION_CHOICE, /* int: index in choices */
    OPTION_LIST,   /* struct text_list: may be given again and again */
    OPTION_DEFINE, /* the same, of NAME=VALUE */
    OPTION_NAMES,  /* struct name_list: NAME[,NAME...], of choices where there are some */
};

#define TEXT_LIST_MAX 256

struct text_list {
    const char *items[TEXT_LIST_MAX];
    int count;
};

#define NAME_LIST_MAX 32

struct name_list {
    char names[NAME_LIST_MAX][80];
    int count;
};

struct option_spec {
    const char *name; /* without the dashes */
    char letter;      /* 0: none */
    enum option_kind kind;
    void *value; /* of the type that kind tells; holds the default */
    const char *metavar, *help;
    double least, most;
    const char *const *choices; /* ends with NULL */
};

struct command_line {
    const char *name;     /* "render" */
    const char *synopsis; /* "SCENE -o OUT.exr [options]" */
    const char *about;
    const struct option_spec *options; /* ends with a NULL name */
    int least_files, most_files;
};

enum parse_result { PARSE_OK, PARSE_HELP, PARSE_WRONG };

/* Fills the options' values. --help=table, for the build alone, prints what --help knows for
 * pipeline/manual, which makes manual pages and shell completion of it: lines
 *     command NAME SYNOPSIS ABOUT
 *     option NAME LETTER OPTION KIND METAVAR CHOICES TAKES HELP
 * with a tab between two fields, - for an empty one and spaces between choices; KIND is flag,
 * choice, names, number, text or define.
 * On PARSE_OK the files are argv[*first_file .. argc - 1]; on
 * PARSE_HELP the help was printed on stdout; on PARSE_WRONG one line on stderr. */
enum parse_result parse_command_line(const struct command_line *line, int argc, char **argv,
                                     int *first_file);

#endif
