/* SPDX-License-Identifier: Apache-2.0 */
/* Python as a child that answers line by line over one socket, which is its stdin and its stdout.
 */

#include "pipeline/peers.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "denoise/nn/embed.h"
#include "features/cancel.h"

extern char **environ;

size_t peers_script_size(void);
NN_EMBED(peers_script, PEERS_SCRIPT)

enum { REPLY_MAX = 4096, MESSAGE_MAX = 400, POLL_MS = 100 };

struct peers {
    pid_t process;  /* 0: none */
    int socket;     /* -1: none */
    FILE *messages; /* what Python writes on stderr */
    const volatile int *cancel;
    char folder[256]; /* of pictures on their way; empty: none */
    char replies[REPLY_MAX];
    size_t reply_size; /* bytes read, of which a line may be taken */
};

static bool cancelled(const struct peers *peers) {
    return cancel_wanted(peers->cancel);
}

/* The last line that Python left on stderr: what a traceback ends with. */
static void last_message(FILE *messages, char text[MESSAGE_MAX]) {
    char line[MESSAGE_MAX];
    text[0] = 0;
    rewind(messages);
    while (fgets(line, sizeof line, messages)) {
        line[strcspn(line, "\n")] = 0;
        if (line[0])
            memcpy(text, line, sizeof line);
    }
}

static int fail_ended(const struct peers *peers, struct fewray_error *error) {
    char text[MESSAGE_MAX];
    last_message(peers->messages, text);
    return fewray_fail(error, FEWRAY_ERROR_IO, NULL, 0, "the peers' Python ended: %s",
                       text[0] ? text : "it said nothing");
}

static int send_line(struct peers *peers, const json_t *request, struct fewray_error *error) {
    char *text = json_dumps(request, JSON_COMPACT);
    if (!text)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for a request");
    const size_t length = strlen(text);
    text[length] = '\n'; /* in the place of the 0 */
    size_t sent = 0;
    while (sent < length + 1) {
        const ssize_t part = send(peers->socket, text + sent, length + 1 - sent, MSG_NOSIGNAL);
        if (part < 0 && errno != EINTR)
            break;
        sent += part > 0 ? (size_t)part : 0;
    }
    free(text);
    return sent == length + 1 ? FEWRAY_OK : fail_ended(peers, error);
}

/* Waits for more of the reply. */
static int receive_some(struct peers *peers, struct fewray_error *error) {
    struct pollfd ready = {.fd = peers->socket, .events = POLLIN};
    while (poll(&ready, 1, POLL_MS) <= 0)
        if (cancelled(peers))
            return fewray_fail(error, FEWRAY_ERROR_CANCELLED, NULL, 0, "interrupted");
    const ssize_t part = read(peers->socket, peers->replies + peers->reply_size,
                              sizeof peers->replies - peers->reply_size);
    if (part < 0 && errno == EINTR)
        return FEWRAY_OK;
    if (part <= 0) /* also where a line is longer than ours can be */
        return fail_ended(peers, error);
    peers->reply_size += (size_t)part;
    return FEWRAY_OK;
}

/* *reply is to be given back by json_decref(); it is an object without "error". */
static int receive_line(struct peers *peers, json_t **reply, struct fewray_error *error) {
    char *end;
    *reply = NULL;
    while (!(end = memchr(peers->replies, '\n', peers->reply_size))) {
        const int status = receive_some(peers, error);
        if (status)
            return status;
    }
    *reply = json_loadb(peers->replies, (size_t)(end - peers->replies), 0, NULL);
    peers->reply_size -= (size_t)(end + 1 - peers->replies);
    memmove(peers->replies, end + 1, peers->reply_size);
    const char *fault = json_string_value(json_object_get(*reply, "error"));
    if (json_is_object(*reply) && !fault)
        return FEWRAY_OK;
    fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, NULL, 0, "the peers' Python says: %s",
                fault ? fault : "something that is no JSON object");
    json_decref(*reply);
    *reply = NULL;
    return FEWRAY_ERROR_UNSUPPORTED;
}

/* Sends the request, which is given up, and waits for the answer's seconds. */
static int ask(struct peers *peers, json_t *request, double *seconds, struct fewray_error *error) {
    json_t *reply = NULL;
    int status = request ? send_line(peers, request, error)
                         : fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory");
    json_decref(request);
    if (!status)
        status = receive_line(peers, &reply, error);
    if (!status)
        *seconds = json_number_value(json_object_get(reply, "seconds"));
    json_decref(reply);
    return status;
}

static char *make_wish(const struct peers_settings *settings) {
    json_t *defines = json_object();
    for (int i = 0; i < settings->define_count; i++) {
        const char *text = settings->defines[i], *value = strchr(text, '=');
        if (value)
            json_object_setn_new(defines, text, (size_t)(value - text), json_string(value + 1));
    }
    json_t *wish =
        json_pack("{s:s, s:o, s:i, s:i, s:i, s:i}", "scene", settings->scene_path, "defines",
                  defines, "width", settings->width, "height", settings->height, "max_depth",
                  settings->max_depth, "threads", settings->threads);
    char *text = wish ? json_dumps(wish, JSON_COMPACT) : NULL;
    json_decref(wish);
    return text;
}

/* Starts `python -c SCRIPT WISH` in a process group of its own: Ctrl-C is ours to pass on. Returns
 * 0 or what errno says. */
static int spawn(struct peers *peers, const char *python, char *script, char *wish, int far_end) {
    char *arguments[] = {(char *)python, "-c", script, wish, NULL};
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, far_end, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, far_end, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(peers->messages), STDERR_FILENO);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    const int fault =
        posix_spawnp(&peers->process, python, &actions, &attributes, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    if (fault)
        peers->process = 0;
    return fault;
}

static int start(struct peers *peers, const struct peers_settings *settings,
                 struct fewray_error *error) {
    int ends[2];
    char *wish = make_wish(settings);
    char *script = strndup((const char *)peers_script, peers_script_size());
    int fault = wish && script ? 0 : ENOMEM;
    if (!fault && socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends))
        fault = errno;
    else if (!fault) {
        peers->socket = ends[0];
        fault = spawn(peers, settings->python, script, wish, ends[1]);
        close(ends[1]);
    }
    free(wish);
    free(script);
    return fault ? fewray_fail(error, FEWRAY_ERROR_IO, settings->python, 0,
                               "can't be started: %s; give a Python with Mitsuba 3 by --python",
                               strerror(fault))
                 : FEWRAY_OK;
}

static int say_hello(struct peers *peers, struct peers_info *info, struct fewray_error *error) {
    json_t *reply;
    const int status = receive_line(peers, &reply, error);
    if (status)
        return status;
    const char *names = json_string_value(json_object_get(reply, "names"));
    snprintf(info->names, sizeof info->names, "%s", names ? names : "Mitsuba");
    info->oidn = json_is_true(json_object_get(reply, "oidn"));
    info->load_s = json_number_value(json_object_get(reply, "load_s"));
    info->compile_s = json_number_value(json_object_get(reply, "compile_s"));
    json_decref(reply);
    return FEWRAY_OK;
}

static bool make_folder(struct peers *peers) {
    const char *parent = getenv("TMPDIR");
    snprintf(peers->folder, sizeof peers->folder, "%s/fewray-XXXXXX",
             parent && *parent ? parent : "/tmp");
    if (mkdtemp(peers->folder))
        return true;
    peers->folder[0] = 0;
    return false;
}

int peers_open(const struct peers_settings *settings, struct peers **out, struct peers_info *info,
               struct fewray_error *error) {
    struct peers *peers = calloc(1, sizeof *peers);
    *out = NULL;
    if (!peers)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the peers");
    peers->socket = -1;
    peers->cancel = settings->cancel;
    peers->messages = tmpfile();
    int status = FEWRAY_OK;
    if (!peers->messages || !make_folder(peers))
        status = fewray_fail(error, FEWRAY_ERROR_IO, NULL, 0,
                             "there is no place for temporary files: %s", strerror(errno));
    if (!status)
        status = start(peers, settings, error);
    if (!status)
        status = say_hello(peers, info, error);
    if (status)
        peers_close(&peers);
    *out = peers;
    return status;
}

static const char *picture_path(const struct peers *peers, const char *name, char *path,
                                size_t size) {
    snprintf(path, size, "%s/%s", peers->folder, name);
    return path;
}

static void remove_folder(const struct peers *peers) {
    char path[300];
    if (!peers->folder[0])
        return;
    unlink(picture_path(peers, "in.exr", path, sizeof path));
    unlink(picture_path(peers, "out.exr", path, sizeof path));
    rmdir(peers->folder);
}

/* Python ends by itself at the end of its input, unless it is at work. */
void peers_close(struct peers **peers) {
    struct peers *closing = *peers;
    if (!closing)
        return;
    if (closing->socket >= 0)
        close(closing->socket);
    if (closing->process) {
        kill(closing->process, SIGTERM);
        while (waitpid(closing->process, NULL, 0) < 0 && errno == EINTR)
            ;
    }
    if (closing->messages)
        fclose(closing->messages);
    remove_folder(closing);
    free(closing);
    *peers = NULL;
}

static int read_picture_of(const struct peers *peers, struct fewray_frame **picture,
                           struct fewray_error *error) {
    char path[300];
    picture_path(peers, "out.exr", path, sizeof path);
    const int status = fewray_frame_read_exr(path, picture, error);
    unlink(path);
    return status;
}

int peers_render(struct peers *peers, int spp, int seed, bool features,
                 struct fewray_frame **picture, double *seconds, struct fewray_error *error) {
    char out[300];
    json_t *request =
        json_pack("{s:s, s:i, s:i, s:b, s:s}", "do", "render", "spp", spp, "seed", seed, "features",
                  features, "out", picture ? picture_path(peers, "out.exr", out, sizeof out) : "");
    if (picture)
        *picture = NULL;
    const int status = ask(peers, request, seconds, error);
    return status || !picture ? status : read_picture_of(peers, picture, error);
}

int peers_denoise(struct peers *peers, const struct fewray_frame *frame,
                  struct fewray_frame **picture, double *seconds, struct fewray_error *error) {
    char in[300], out[300];
    *picture = NULL;
    picture_path(peers, "in.exr", in, sizeof in);
    int status = fewray_frame_write_exr(frame, in, true, error);
    if (!status)
        status = ask(peers,
                     json_pack("{s:s, s:s, s:s}", "do", "denoise", "in", in, "out",
                               picture_path(peers, "out.exr", out, sizeof out)),
                     seconds, error);
    return status ? status : read_picture_of(peers, picture, error);
}
