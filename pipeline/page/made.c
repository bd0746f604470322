/* SPDX-License-Identifier: Apache-2.0 */
/* How the pictures were made, as far as their statistics and the bench tell. */

#include <math.h>
#include <string.h>

#include "pipeline/page/page.h"

static const char *text_of(const json_t *object, const char *key) {
    return json_string_value(json_object_get(object, key));
}

static void put_item(const struct page *page, const char *before, const char *text) {
    if (!text)
        return;
    fputs(before, page->file);
    html_text(page->file, text);
}

/* "2 threads of AMD EPYC, fewray 0.1.0" */
static void put_machine(const struct page *page, const json_t *threads, const char *cpu,
                        const char *version) {
    const char *comma = "";
    if (json_is_integer(threads)) {
        fprintf(page->file, "%lld threads%s", (long long)json_integer_value(threads),
                cpu ? " of " : "");
        comma = ", ";
    }
    if (cpu) {
        html_text(page->file, cpu);
        comma = ", ";
    }
    if (version)
        fputs(comma, page->file);
    put_item(page, "fewray ", version);
}

/* Words that aren't parted where there is room: browsers would break "--spp" behind its dashes. */
static void put_command(const struct page *page, const char *command) {
    fputs("<code>", page->file);
    while (*command) {
        char word[1024];
        const size_t length = strcspn(command, " ");
        snprintf(word, sizeof word, "%.*s", (int)(length < 1000 ? length : 1000), command);
        fputs("<span class=\"word\">", page->file);
        html_text(page->file, word);
        fputs("</span> ", page->file);
        command += length < 1000 ? length + (command[length] == ' ') : 1000;
    }
    fputs("</code><br>", page->file);
}

/* A command line with what ran it. */
static void put_entry(const struct page *page, const char *name, int name_length,
                      const json_t *stats) {
    const char *command = text_of(stats, "command");
    char label[320];
    if (!stats)
        return;
    snprintf(label, sizeof label, "%.*s", name_length, name);
    fputs("<dt>", page->file);
    html_text(page->file, label);
    fputs("</dt>\n<dd>", page->file);
    if (command)
        put_command(page, command);
    else if (text_of(stats, "scene")) {
        put_item(page, "", text_of(stats, "method"));
        put_item(page, ", scene ", text_of(stats, "scene"));
        fprintf(page->file, ", seed %lld<br>",
                (long long)json_integer_value(json_object_get(stats, "seed")));
    }
    put_machine(page, json_object_get(stats, "threads"), text_of(stats, "cpu"),
                text_of(stats, "version"));
    fputs("</dd>\n", page->file);
}

static void put_bench(const struct page *page) {
    const json_t *settings = json_object_get(page->bench, "settings"),
                 *machine = json_object_get(page->bench, "machine");
    const json_t *seeds = json_object_get(settings, "seeds");
    if (!page->bench)
        return;
    fputs("<dt>fewray bench</dt>\n<dd>", page->file);
    put_item(page, "scene ", text_of(settings, "scene"));
    put_item(page, ", reference ", text_of(settings, "reference"));
    if (json_is_integer(seeds))
        fprintf(page->file, ", %lld seeds", (long long)json_integer_value(seeds));
    put_item(page, ", ", text_of(json_object_get(page->bench, "peers"), "names"));
    fputs("<br>", page->file);
    put_machine(page, json_object_get(machine, "threads"), text_of(machine, "cpu"),
                text_of(page->bench, "version"));
    fputs("</dd>\n", page->file);
}

void page_made(const struct page *page) {
    fputs("<section>\n<h2>How this was made</h2>\n", page->file);
    fputs("<dl class=\"made\">\n", page->file);
    for (int i = 0; i < page->folder.count; i++)
        put_entry(page, page->folder.names[i], (int)strlen(page->folder.names[i]) - 4,
                  page->stats[i]);
    put_entry(page, "reference", 9, page->stats[PAGE_FILES_MAX]);
    put_bench(page);
    fputs("</dl>\n<p class=\"note\">", page->file);
    if (page->width > 0) {
        const struct page_size shown =
            page_shown_size(page->width, page->height, page->options->max_width);
        fprintf(page->file, "Pictures of %d&times;%d pixels", page->width, page->height);
        if (shown.width < page->width)
            fprintf(page->file, ", shown as %d&times;%d and judged in full", shown.width,
                    shown.height);
        fputs(", sRGB", page->file);
        if (page->options->exposure != 0)
            fprintf(page->file, ", %+.2g stops", (double)page->options->exposure);
        fputs(". ", page->file);
    }
    fputs("This page is one file, made by <code>fewray report</code> of fewray " FEWRAY_VERSION
          "; it loads nothing.</p>\n</section>\n",
          page->file);
}
