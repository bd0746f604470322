/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_H
#define FEWRAY_PIPELINE_H

/* The whole way from a scene file to a finished picture in one call, and the judging of pictures:
 * metrics and before/after composites. What the `fewray` command does, for programs. */

#include "fewray/denoise.h"
#include "fewray/guide.h"

#ifdef __cplusplus
extern "C" {
#endif

/* --- one call from scene.xml to picture.exr */

/* Files to leave; NULL where not wanted. Either all of them appear or none. */
struct fewray_outputs {
    const char *exr;   /* every layer of the frame */
    const char *png;   /* R, G, B as an 8-bit sRGB picture */
    const char *stats; /* struct fewray_run_stats as JSON */
    /* PNG of the samples so far, replaced again and again while they are traced, denoised by the
     * fast network where the picture is to be; smaller by a whole factor where the picture has more
     * than a million pixels. In the end it is what png is. */
    const char *preview;
    bool float32; /* 32-bit floats in the EXR instead of half */
};

/* How far a run is. */
struct fewray_progress {
    const char
        *phase; /* "load", "bvh", "first look", "guide", "render", "edges", "denoise", "write" */
    double fraction;     /* of the whole run's time, 0..1; never falls */
    double seconds_left; /* of the whole run; negative: not known yet */
};

/* What a render is to reach instead of a number of samples. All zero: settings.spp samples
 * everywhere. Not for practical path guiding. */
struct fewray_goal {
    double seconds; /* > 0: of wall time for the whole run; what is sampled then depends on the
                       machine's speed, and the picture with it */
    double spent;   /* of these seconds, before fewray_job_run() */
    double error; /* > 0: mrse of the finished picture, as an estimate sees it; seconds must be 0 */
    int max_spp;  /* with error: samples a pixel at most, mean over the picture; 0 = 4096 */
    bool adaptive;  /* tiles of 16 x 16 pixels get samples by their expected error; with neither
                       seconds nor error: settings.spp in the mean over the picture */
    bool any_model; /* seconds may be saved by the denoiser's fast model */
};

struct fewray_job {
    const char *scene_path;
    struct fewray_goal goal;
    struct fewray_scene_options scene;      /* its threads are ignored: settings.threads counts */
    struct fewray_render_settings settings; /* threads, progress and cancel hold for every step;
                                               its pauses are the preview's and the checkpoints'
                                               where there are some, its state the latter's */
    bool guided, denoised;
    bool pilot; /* a guided render first looks whether guiding pays, and does without where it
                   doesn't */
    bool ppg; /* where guided: by practical path guiding, which learns while it renders, instead of
                 by maps */
    struct fewray_denoise_options
        denoise; /* its threads, progress and cancel are ignored, as above */
    struct fewray_outputs outputs;
    int part, parts;    /* 1..parts: this share of the samples of each pixel, settings.spp of
                           parts * settings.spp, goes into outputs.exr for fewray_merge_run(), never
                           denoised, always as 32-bit floats; parts = 0: a whole picture */
    bool skip_existing; /* a part that is there already, whole and of the same scene and settings,
                           isn't rendered again */
    float preview_interval; /* seconds between two previews, at least: all of them take a few per
                               cent of the time at most; 1 */
    /* NULL; a file that holds the state of the render so far, replaced as a whole now and then and
     * where settings.cancel ends it, and removed when the outputs are there. Where it exists at the
     * start the render goes on with it, to the same bits; a damaged one, or one of another scene or
     * of other settings, is refused. The number of threads, the denoiser, the outputs and, where
     * the samples that are done are the first ones of both, spp may differ. Not for goals,
     * sequences, teams and practical path guiding. */
    const char *checkpoint;
    bool must_resume;           /* where it doesn't exist that is an error */
    double checkpoint_interval; /* seconds between two, at least (300): all of them take 2 % of the
                                   time at most; 0: after every tile, whatever it takes */
    /* NULL; told at once: that the run goes on with a checkpoint, that one can't be written. */
    void (*note)(void *user, const char *text);
    void *note_user;
    /* NULL; of the whole run, where settings.progress tells of single phases. From any thread, one
     * at a time. */
    void (*progress)(void *user, const struct fewray_progress *progress);
    void *progress_user;
    void (*warn)(void *user, const char *text); /* NULL; called after success, once for each warning
                                                   of the scene and one for what half floats lost */
    void *warn_user;
};
/* 4 samples a pixel, guided and denoised, no outputs. */
FEWRAY_API void fewray_job_init(struct fewray_job *job);

#define FEWRAY_PLAN_REASONS 12

/* What the planner decided for a goal, and why. */
struct fewray_plan {
    bool made;               /* there was a goal */
    double wanted_s;         /* 0: none */
    double predicted_s;      /* of the whole run, at the last decision; 0: no prediction */
    double wanted_error;     /* 0: none */
    double estimated_error;  /* mrse of the finished picture; NaN: not known */
    double spp;              /* samples a pixel, mean over the picture, the first look included */
    int least_spp, most_spp; /* of the tiles */
    int passes, pictures;    /* of samples; denoised on the way or at the end */
    bool adaptive;           /* tiles got unequal numbers of samples */
    bool hit_max_spp;        /* before the error was reached */
    bool too_short;          /* one sample a pixel took longer than the seconds wanted */
    int reason_count;
    char reasons[FEWRAY_PLAN_REASONS][200]; /* a sentence each: what was decided, and why */
};

/* Seconds are of wall time; a step that was left out took 0. */
struct fewray_run_stats {
    double load_s, bvh_s, initial_s, guide_s, render_s, denoise_s, write_s, total_s;
    int width, height, spp, threads;
    struct fewray_render_stats counts;
    int tiles, tiles_denoised; /* of the denoiser */
    size_t repaired;           /* bad pixels of the file that was read; 0 for a render */
    size_t clipped, lost;      /* pixels of an EXR of half floats: fewray_frame_half_losses() */
    int unused_textures;       /* bitmaps that weren't read: no material of a shape uses them */
    int previews;              /* written while samples were traced, in preview_s */
    double preview_s;          /* part of initial_s and render_s */
    int resumes;               /* earlier runs whose samples this one goes on with; 0: none */
    double resumed_spp;        /* samples a pixel that were done by then */
    double earlier_s;          /* of wall time, that they took; no other seconds count them */
    int checkpoints;           /* written, in checkpoint_s */
    double checkpoint_s;       /* part of initial_s and render_s */
    bool no_images;            /* the scene needed no image library */
    bool guide_skipped;        /* the pilot advised against the guide */
    bool first_look_was_all;   /* a guided render whose samples were all spent on the first look */
    bool kept;                 /* the part was there already */
    struct fewray_plan plan;
};

/* Loads, looks, guides, renders, denoises and writes. *picture (picture may be NULL) gets the frame
 * and is owned by the caller; stats may be NULL. Where settings.cancel ends the work, what is done
 * so far is written all the same, without the denoiser, and FEWRAY_ERROR_CANCELLED returned; so is
 * the picture that a denoiser failed on, with the denoiser's error. */
FEWRAY_API int fewray_job_run(const struct fewray_job *job, struct fewray_frame **picture,
                              struct fewray_run_stats *stats, struct fewray_error *error);

/* --- parts of a picture to the picture */

struct fewray_merge_job {
    const char *const *paths; /* (count): files of fewray_job_run() with parts, in any order */
    int count;
    bool partial; /* parts may be missing */
    bool denoised;
    struct fewray_denoise_options
        denoise; /* its threads, progress and cancel are ignored: those below count */
    struct fewray_outputs outputs;
    int threads;                                                      /* 0 = all cores */
    void (*progress)(void *user, const char *phase, double fraction); /* NULL */
    void *progress_user;
    const volatile int *cancel; /* NULL; non-zero ends the work with FEWRAY_ERROR_CANCELLED */
};
/* Denoised, no parts, no outputs. */
FEWRAY_API void fewray_merge_job_init(struct fewray_merge_job *job);

/* Checks that the parts belong together and merges them, weighted by each pixel's number of
 * samples, one file after another; the result doesn't depend on the order of the paths. A part that
 * is missing, given twice, damaged or of another picture is an error that names it. *picture
 * (picture may be NULL) is owned by the caller; stats may be NULL: load_s holds the seconds of
 * reading and merging. */
FEWRAY_API int fewray_merge_run(const struct fewray_merge_job *job, struct fewray_frame **picture,
                                struct fewray_run_stats *stats, struct fewray_error *error);

/* --- many frames */

/* first, first + step, ... up to last; none is negative. */
struct fewray_frames {
    int first, last, step;
};

struct fewray_sequence {
    struct fewray_frames frames;
    float fps;          /* frames of a second; frame 0 is at second 0 (24) */
    bool temporal;      /* where denoised, what is filtered is the mean over the frames so far */
    bool skip_existing; /* frames whose output files are all there are left as they are */
    void (*frame_done)(void *user, int frame, const struct fewray_run_stats *stats); /* NULL */
    void *user;
};
/* One frame, number 0. */
FEWRAY_API void fewray_sequence_init(struct fewray_sequence *sequence);

/* Renders the frames one after another, each with the camera at its own time and a seed of its own
 * made of the job's and its number. The scene is loaded once, unless it has $frame, which gets the
 * frame's number. Names of the job's outputs have a run of # or a %04d for that number. A cancelled
 * frame is written as fewray_job_run() does, and no more begun. */
FEWRAY_API int fewray_sequence_run(const struct fewray_job *job,
                                   const struct fewray_sequence *sequence,
                                   struct fewray_error *error);

/* --- pictures of other renderers */

/* Gives the layers of a frame that Blender, Mitsuba 3, pbrt-v4, Arnold, RenderMan, V-Ray or Karma
 * wrote fewray's own names, for each layer that the frame lacks: what `fewray info` tells. noisy:
 * of a picture that its renderer denoised and kept beside it, the noisy one is the colour. */
FEWRAY_API void fewray_frame_adopt_names(struct fewray_frame *frame, bool noisy);

/* --- metrics */

/* Of x, the test, against r, the reference (linear RGB; means over pixels and channels; lower is
 * better but for psnr). Pixels where r isn't finite are left out; a pixel where x isn't finite
 * counts as x = 2 r + 1. NaN: not known. */
struct fewray_metrics {
    double mrse;         /* (x - r)^2 / (r^2 + 0.01) */
    double mrse_trimmed; /* the same without the ceil(0.01 %) of the pixels that have the highest
                            error */
    double mrse_top1;    /* share, 0..1, of the mrse in the ceil(1 %) of the pixels that have the
                            highest error: at edges, for a denoised picture */
    double mse;          /* (x - r)^2 */
    double mape;         /* |x - r| / (|r| + 0.01) */
    double l1;           /* |x - r| */
    double psnr;         /* dB, of the display images: sRGB transfer function of 0..1 */
    /* 1 - SSIM of the display images (Wang et al. 2004, eq. 13: Gaussian window of 11 pixels, sigma
     * 1.5, borders of 5 pixels left out); NaN below 11x11 pixels */
    double ssim_loss;
    double flip; /* mean LDR-FLIP of the display images at 67 pixels per degree (Andersson et al.
                    2020), 0..1; pixels left out count as equal */
    /* The reference's own noise, stderr^2 / (r^2 + 0.01), where it has stderr.R/G/B. */
    double ref_mrse;
    double mrse_net; /* mrse - ref_mrse: about the error against a noise-free reference */
    long long n_nonfinite, n_ref_nonfinite; /* pixels */
};
/* Compares the R, G, B of two frames of the same size. */
FEWRAY_API int fewray_compare(const struct fewray_frame *test, const struct fewray_frame *reference,
                              struct fewray_metrics *metrics, struct fewray_error *error);

#define FEWRAY_SCORE_BINS 10

/* Differences of blocks of pixels in units of their standard error: of a right renderer they are
 * normal, with mean 0 and deviation 1 (less where the test's variance layer overestimates, as it
 * does for Sobol points). */
struct fewray_block_scores {
    long long count;                        /* blocks times channels */
    double mean, deviation, largest;        /* of z; largest: |z| */
    double ratio_of_means;                  /* radiance of the test / of the reference */
    long long beyond_2, beyond_3;           /* |z| > 2: 4.6 % expected; |z| > 3: 0.27 % */
    long long histogram[FEWRAY_SCORE_BINS]; /* z in steps of 1 from -5 to 5, the ends open */
};
/* z of each whole block of block x block pixels and each channel, from the reference's stderr.R/G/B
 * and the test's variance.R/G/B (taken as 0 where it has none). */
FEWRAY_API int fewray_block_zscores(const struct fewray_frame *test,
                                    const struct fewray_frame *reference, int block,
                                    struct fewray_block_scores *scores, struct fewray_error *error);

/* --- composites */

#define FEWRAY_CROPS 3

struct fewray_crop {
    int x, y, width, height; /* pixels of the picture */
};

struct fewray_composite_options {
    const char *caption; /* a line below the pictures; NULL */
    float exposure;      /* in stops, before the sRGB transfer function */
    int crop_count;      /* 0: three places are picked where error and detail are highest */
    struct fewray_crop crops[FEWRAY_CROPS];
};

/* Draws noisy | denoised | reference (reference may be NULL) with magnified crops and, against the
 * reference, error heat maps and metrics; writes a PNG, whole or not at all. A noisy frame that has
 * noisy.R/G/B is shown by them, so that one frame can be both noisy and denoised. options may be
 * NULL. */
FEWRAY_API int fewray_composite(const struct fewray_frame *noisy,
                                const struct fewray_frame *denoised,
                                const struct fewray_frame *reference,
                                const struct fewray_composite_options *options,
                                const char *png_path, struct fewray_error *error);

#ifdef __cplusplus
}
#endif
#endif
