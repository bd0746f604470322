/* SPDX-License-Identifier: Apache-2.0 */
/* getopt_long driven by a table of options; every value is checked to the last character. */

#include "pipeline/options.h"

#include <ctype.h>
#include <errno.h>
#include <getopt.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pipeline/command.h"

enum { OPTIONS_MAX = 64, HELP_CODE = 1000, FIRST_CODE = 1001 };

static bool parse_int(const struct option_spec *option, const char *text) {
    char *end;
    errno = 0;
    const long value = strtol(text, &end, 10);
    if (errno || end == text || *end || isspace((unsigned char)*text) || value < option->least ||
        value > option->most)
        return false;
    *(int *)option->value = (int)value;
    return true;
}

static bool parse_seed(const struct option_spec *option, const char *text) {
    char *end;
    errno = 0;
    const unsigned long long value = strtoull(text, &end, 10);
    if (errno || *end || !isdigit((unsigned char)*text)) /* strtoull takes "-1" */
        return false;
    *(uint64_t *)option->value = value;
    return true;
}

static bool parse_float(const struct option_spec *option, const char *text) {
    char *end;
    const double value = strtod(text, &end);
    if (end == text || *end || isspace((unsigned char)*text) ||
        !(value >= option->least && value <= option->most))
        return false;
    *(float *)option->value = (float)value;
    return true;
}

/* A positive number of bytes, "512M". */
static bool parse_size(const struct option_spec *option, const char *text) {
    static const char units[] = "KMG";
    char *end;
    errno = 0;
    const unsigned long long value = strtoull(text, &end, 10);
    if (errno || !isdigit((unsigned char)*text) || value == 0)
        return false;
    int shift = 0;
    if (*end) {
        const char *unit = strchr(units, toupper((unsigned char)*end));
        if (!unit || end[1])
            return false;
        shift = 10 * (int)(unit - units + 1);
    }
    if (value > SIZE_MAX >> shift)
        return false;
    *(size_t *)option->value = (size_t)value << shift;
    return true;
}

/* A positive time, "500ms". */
static bool parse_time(const struct option_spec *option, const char *text) {
    static const struct {
        const char *name;
        double seconds;
    } units[] = {{"", 1}, {"ms", 1e-3}, {"s", 1}, {"m", 60}};
    char *end;
    const double value = strtod(text, &end);
    if (!isdigit((unsigned char)*text) || strpbrk(text, "xX"))
        return false;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (!strcmp(end, units[i].name) && value > 0 && value * units[i].seconds <= 1e9) {
            *(double *)option->value = value * units[i].seconds;
            return true;
        }
    return false;
}

static bool parse_choice(const struct option_spec *option, const char *text) {
    for (int i = 0; option->choices[i]; i++)
        if (!strcmp(option->choices[i], text)) {
            *(int *)option->value = i;
            return true;
        }
    return false;
}

static bool parse_list(const struct option_spec *option, const char *text) {
    struct text_list *list = option->value;
    if (list->count == TEXT_LIST_MAX)
        return false;
    list->items[list->count++] = text;
    return true;
}

static bool is_choice(const struct option_spec *option, const char *name) {
    int i = 0;
    while (option->choices && option->choices[i] && strcmp(option->choices[i], name))
        i++;
    return !option->choices || option->choices[i];
}

static bool parse_names(const struct option_spec *option, const char *text) {
    struct name_list *list = option->value;
    for (;; text++) {
        const char *end = strchr(text, ',');
        const size_t length = end ? (size_t)(end - text) : strlen(text);
        if (list->count == NAME_LIST_MAX || length == 0 || length >= sizeof *list->names)
            return false;
        char *name = list->names[list->count];
        memcpy(name, text, length);
        name[length] = 0;
        if (!is_choice(option, name))
            return false;
        list->count++;
        if (!end)
            return true;
        text = end;
    }
}

static bool parse_value(const struct option_spec *option, const char *text) {
    switch (option->kind) {
    case OPTION_FLAG:
        *(bool *)option->value = true;
        return true;
    case OPTION_TEXT:
        *(const char **)option->value = text;
        return *text != 0;
    case OPTION_INT:
        return parse_int(option, text);
    case OPTION_SEED:
        return parse_seed(option, text);
    case OPTION_FLOAT:
        return parse_float(option, text);
    case OPTION_SIZE:
        return parse_size(option, text);
    case OPTION_TIME:
        return parse_time(option, text);
    case OPTION_CHOICE:
        return parse_choice(option, text);
    case OPTION_LIST:
        return parse_list(option, text);
    case OPTION_DEFINE:
        return strchr(text, '=') && *text != '=' && parse_list(option, text);
    case OPTION_NAMES:
        return parse_names(option, text);
    }
    return false;
}

/* What the option takes, for messages and help: "on|off", "1..64", "a text". */
static const char *describe_value(const struct option_spec *option, char *text, size_t size) {
    size_t used = 0;
    switch (option->kind) {
    case OPTION_INT:
    case OPTION_FLOAT:
        snprintf(text, size, "%g..%.15g", option->least, option->most);
        break;
    case OPTION_SIZE:
        snprintf(text, size, "bytes, or a number and K, M or G, as 512M");
        break;
    case OPTION_TIME:
        snprintf(text, size, "a time above 0, as 500ms, 5s, 2m or a number of seconds");
        break;
    case OPTION_SEED:
        snprintf(text, size, "0..%llu", ULLONG_MAX);
        break;
    case OPTION_CHOICE:
        text[0] = 0;
        for (int i = 0; option->choices[i] && used < size; i++)
            used += (size_t)snprintf(text + used, size - used, "%s%s", i ? "|" : "",
                                     option->choices[i]);
        break;
    case OPTION_DEFINE:
        snprintf(text, size, "NAME=VALUE, at most %d times", TEXT_LIST_MAX);
        break;
    case OPTION_LIST:
        snprintf(text, size, "at most %d of them", TEXT_LIST_MAX);
        break;
    case OPTION_NAMES:
        snprintf(text, size, "at most %d names, separated by commas", NAME_LIST_MAX);
        for (int i = 0; option->choices && option->choices[i] && used < size; i++)
            used += (size_t)snprintf(text + used, size - used, "%s%s", i ? "," : "",
                                     option->choices[i]);
        break;
    case OPTION_FLAG:
    case OPTION_TEXT:
        snprintf(text, size, "a text that isn't empty");
    }
    return text;
}

static void print_option(const struct option_spec *option) {
    char left[80], takes[80];
    const char *value = option->kind == OPTION_CHOICE ? describe_value(option, takes, sizeof takes)
                                                      : option->metavar;
    char letter[8] = "";
    if (option->letter)
        snprintf(letter, sizeof letter, "-%c, ", option->letter);
    snprintf(left, sizeof left, "%s--%s %s", letter, option->name, value ? value : "");
    printf("  %-34s %s\n", left, option->help);
}

static void print_help(const struct command_line *line) {
    printf("usage: fewray %s %s\n\n%s\n\noptions:\n", line->name, line->synopsis, line->about);
    for (const struct option_spec *option = line->options; option->name; option++)
        print_option(option);
    printf("  %-34s %s\n", "--help", "this text");
}

static const char *kind_name(enum option_kind kind) {
    switch (kind) {
    case OPTION_FLAG:
        return "flag";
    case OPTION_CHOICE:
        return "choice";
    case OPTION_NAMES:
        return "names";
    case OPTION_TEXT:
        return "text";
    case OPTION_LIST:
    case OPTION_DEFINE:
        return "define";
    case OPTION_INT:
    case OPTION_SEED:
    case OPTION_FLOAT:
    case OPTION_SIZE:
    case OPTION_TIME:
        break;
    }
    return "number";
}

static void print_table_row(const char *command, const struct option_spec *option) {
    char takes[80];
    const bool is_text = option->kind == OPTION_FLAG || option->kind == OPTION_TEXT;
    printf("option\t%s\t%c\t%s\t%s\t%s\t", command, option->letter ? option->letter : '-',
           option->name, kind_name(option->kind), option->metavar ? option->metavar : "-");
    for (int i = 0; option->choices && option->choices[i]; i++)
        printf("%s%s", i ? " " : "", option->choices[i]);
    printf("%s\t%s\t%s\n", option->choices ? "" : "-",
           is_text || option->choices ? "-" : describe_value(option, takes, sizeof takes),
           option->help);
}

static void print_table(const struct command_line *line) {
    static const struct option_spec help = {.name = "help", .help = "print a short text"};
    printf("command\t%s\t%s\t", line->name, line->synopsis);
    for (const char *c = line->about; *c; c++)
        putchar(*c == '\n' ? ' ' : *c);
    putchar('\n');
    for (const struct option_spec *option = line->options; option->name; option++)
        print_table_row(line->name, option);
    print_table_row(line->name, &help);
}

/* The table as getopt_long wants it; returns the number of options. */
static int make_getopt_table(const struct command_line *line, struct option longs[],
                             char *letters) {
    int count = 0;
    char *letter = letters;
    *letter++ = ':'; /* a missing value is told apart from an unknown option */
    for (; line->options[count].name; count++) {
        const struct option_spec *option = &line->options[count];
        const int takes = option->kind == OPTION_FLAG ? no_argument : required_argument;
        longs[count] = (struct option){option->name, takes, NULL, FIRST_CODE + count};
        if (option->letter) {
            *letter++ = option->letter;
            if (takes == required_argument)
                *letter++ = ':';
        }
    }
    *letter = 0;
    longs[count] = (struct option){"help", optional_argument, NULL, HELP_CODE};
    longs[count + 1] = (struct option){0};
    return count;
}

static const struct option_spec *find_option(const struct command_line *line, int code) {
    if (code >= FIRST_CODE)
        return &line->options[code - FIRST_CODE];
    for (const struct option_spec *option = line->options; option->name; option++)
        if (option->letter && option->letter == code)
            return option;
    return NULL;
}

static enum parse_result wrong_option(const struct command_line *line, int code, char **argv) {
    const struct option_spec *option = find_option(line, optopt);
    if (code == ':' && option)
        report_usage("%s: --%s needs a value %s", line->name, option->name,
                     option->metavar ? option->metavar : "");
    else if (option)
        report_usage("%s: --%s takes no value", line->name, option->name);
    else if (optopt)
        report_usage("%s: there is no option -%c; `fewray %s --help` lists them", line->name,
                     optopt, line->name);
    else
        report_usage("%s: there is no option %s; `fewray %s --help` lists them", line->name,
                     argv[optind - 1], line->name);
    return PARSE_WRONG;
}

static enum parse_result help(const struct command_line *line, const char *value) {
    if (value && strcmp(value, "table")) {
        report_usage("%s: --help takes no value", line->name);
        return PARSE_WRONG;
    }
    if (value)
        print_table(line);
    else
        print_help(line);
    return PARSE_HELP;
}

enum parse_result parse_command_line(const struct command_line *line, int argc, char **argv,
                                     int *first_file) {
    struct option longs[OPTIONS_MAX + 2];
    char letters[2 * OPTIONS_MAX + 2];
    make_getopt_table(line, longs, letters);
    opterr = 0;
    optind = 0; /* glibc: forget an earlier call */
    for (int code; (code = getopt_long(argc, argv, letters, longs, NULL)) != -1;) {
        if (code == HELP_CODE)
            return help(line, optarg);
        if (code == '?' || code == ':')
            return wrong_option(line, code, argv);
        const struct option_spec *option = find_option(line, code);
        if (!parse_value(option, optarg)) {
            char takes[80];
            report_usage("%s: --%s can't be '%s'; it takes %s", line->name, option->name, optarg,
                         describe_value(option, takes, sizeof takes));
            return PARSE_WRONG;
        }
    }
    *first_file = optind;
    const int files = argc - optind;
    if (files < line->least_files)
        report_usage("%s: too few files; usage: fewray %s %s", line->name, line->name,
                     line->synopsis);
    else if (files > line->most_files)
        report_usage("%s: '%s' is a file too many; usage: fewray %s %s", line->name,
                     argv[optind + line->most_files], line->name, line->synopsis);
    else
        return PARSE_OK;
    return PARSE_WRONG;
}
