/* SPDX-License-Identifier: Apache-2.0 */
/* The metrics of all pictures as a table. */

#include <math.h>

#include "pipeline/page/page.h"

static const struct column {
    const char *head, *about;
    size_t offset; /* of the metric */
    bool higher_is_better, with_noise;
} COLUMNS[] = {
    {"mrse", "mean of (x - r)^2 / (r^2 + 0.01); no unit", offsetof(struct fewray_metrics, mrse),
     false, false},
    {"mrse, net", "less the reference's own noise; no unit",
     offsetof(struct fewray_metrics, mrse_net), false, true},
    {"1 &minus; SSIM", "of the displayed pictures; no unit",
     offsetof(struct fewray_metrics, ssim_loss), false, false},
    {"FLIP", "of the displayed pictures, 0 to 1", offsetof(struct fewray_metrics, flip), false,
     false},
    {"PSNR [dB]", "of the displayed pictures", offsetof(struct fewray_metrics, psnr), true, false},
};
enum { COLUMN_COUNT = sizeof COLUMNS / sizeof *COLUMNS };

static double value_of(const struct page_row *row, const struct column *column) {
    return *(const double *)((const char *)&row->metrics + column->offset);
}

static bool is_shown(const struct page *page, const struct column *column) {
    if (!page->reference)
        return false;
    for (int i = 0; i < page->row_count && column->with_noise; i++)
        if (page->rows[i].judged && !isnan(value_of(&page->rows[i], column)))
            return true;
    return !column->with_noise;
}

static double best_of(const struct page *page, const struct column *column) {
    double best = NAN;
    for (int i = 0; i < page->row_count; i++)
        if (page->rows[i].judged)
            best = (column->higher_is_better ? fmax : fmin)(best, value_of(&page->rows[i], column));
    return best;
}

static void put_head(const struct page *page) {
    fputs("<thead><tr><th scope=\"col\">picture</th>", page->file);
    for (int c = 0; c < COLUMN_COUNT; c++)
        if (is_shown(page, &COLUMNS[c])) {
            fputs("<th scope=\"col\" title=\"", page->file);
            html_text(page->file, COLUMNS[c].about);
            fprintf(page->file, "\">%s %s</th>", COLUMNS[c].head,
                    COLUMNS[c].higher_is_better
                        ? "<span aria-label=\"higher is better\">&uarr;</span>"
                        : "<span aria-label=\"lower is better\">&darr;</span>");
        }
    fputs("<th scope=\"col\">samples a pixel</th><th scope=\"col\">work [s]</th></tr></thead>\n",
          page->file);
}

static void put_number(const struct page *page, double value, bool best) {
    if (isnan(value))
        fputs("<td>&ndash;</td>", page->file);
    else if (isinf(value))
        fputs(best ? "<td><strong>&infin;</strong></td>" : "<td>&infin;</td>", page->file);
    else
        fprintf(page->file, best ? "<td><strong>%.4g</strong></td>" : "<td>%.4g</td>", value);
}

static void put_row(const struct page *page, const struct page_row *row,
                    const double best[COLUMN_COUNT]) {
    fputs("<tr><th scope=\"row\">", page->file);
    html_text(page->file, row->label);
    fputs("</th>", page->file);
    for (int c = 0; c < COLUMN_COUNT; c++)
        if (is_shown(page, &COLUMNS[c])) {
            const double value = row->judged ? value_of(row, &COLUMNS[c]) : NAN;
            put_number(page, value, value == best[c]);
        }
    put_number(page, row->spp > 0 ? row->spp : NAN, false);
    put_number(page, row->seconds, false);
    fputs("</tr>\n", page->file);
}

void page_table(const struct page *page) {
    double best[COLUMN_COUNT];
    if (page->row_count == 0)
        return;
    for (int c = 0; c < COLUMN_COUNT; c++)
        best[c] = best_of(page, &COLUMNS[c]);
    fputs("<section>\n<h2>Figures</h2>\n<div class=\"wide\" tabindex=\"0\" role=\"region\" "
          "aria-label=\"Figures\">\n<table>\n",
          page->file);
    put_head(page);
    fputs("<tbody>\n", page->file);
    for (int i = 0; i < page->row_count; i++)
        put_row(page, &page->rows[i], best);
    fputs("</tbody>\n</table>\n</div>\n<p class=\"note\">", page->file);
    fputs(page->reference
              ? "x: the picture, r: the reference. The best of each column is marked. 1 &minus; "
                "SSIM, FLIP and PSNR see what a display shows (sRGB, clipped at 1). "
              : "There is no reference to judge by. ",
          page->file);
    fputs("Work: seconds of wall time from the first look to the denoiser, without loading and "
          "writing.</p>\n</section>\n\n",
          page->file);
}
