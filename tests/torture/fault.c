/* Preloaded into a child process: makes one of its calls that change files below a folder fail, or ends the process there.
 *
 * FARFIELD_FAULT = "<mode> <n> <folder> <log>"; the n-th call fails, counted from 1. Modes:
 *   eio, enospc  the call fails with that error, and the ones after it succeed;
 *   full         from the n-th call on nothing that takes space succeeds, after half of the n-th write was written;
 *   kill         the process ends in place of the call, as by SIGKILL;
 *   read         the n-th call that reads fails with EIO.
 * The log gets one line per fault, and at the end of the process the number of calls that were counted.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

enum { EIO_MODE, ENOSPC_MODE, FULL, KILL, READ };
enum { FILES = 65536 };
static const char *const names[] = {"eio", "enospc", "full", "kill", "read"};
static int mode;
static long target;
static char folder[4096], log_path[4096];
static size_t folder_length;
static atomic_long counted;
static atomic_char tracked[FILES];

static void say(const char *what, const char *path) {
    char line[4600];
    int length = snprintf(line, sizeof line, "%s %s\n", what, path);
    int fd = (int)syscall(SYS_openat, AT_FDCWD, log_path, O_WRONLY | O_CREAT | O_APPEND, 0644);
    if (fd >= 0) {
        (void)!syscall(SYS_write, fd, line, (size_t)length);
        syscall(SYS_close, fd);
    }
}

__attribute__((constructor)) static void begin(void) {
    char name[16] = "";
    const char *text = getenv("FARFIELD_FAULT");
    if (!text || sscanf(text, "%15s %ld %4095s %4095s", name, &target, folder, log_path) != 4) {
        target = 0;
        return;
    }
    for (mode = 0; mode < READ && strcmp(names[mode], name); mode++) {
    }
    folder_length = strlen(folder);
    unsetenv("LD_PRELOAD");
}

__attribute__((destructor)) static void end(void) {
    if (target) {
        char text[32];
        snprintf(text, sizeof text, "%ld", (long)counted);
        say("counted", text);
    }
}

static int below(const char *path) {
    return target && path && !strncmp(path, folder, folder_length);
}

static int is_tracked(int fd) {
    return target && fd >= 0 && fd < FILES && tracked[fd];
}

/* Whether the call fails: it is the n-th of its class. `space`: it takes space; `read`: it reads. */
static int fails(const char *what, const char *path, int fd, int space, int read) {
    if (read != (mode == READ) || (mode == FULL && !space))
        return 0;
    long n = ++counted;
    if (mode == FULL ? n < target : n != target)
        return 0;
    if (n == target) {
        char link[64], name[4096] = "";
        if (!path) {
            snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
            (void)!readlink(link, name, sizeof name - 1);
            path = name;
        }
        say(what, path);
        if (mode == KILL)
            kill(getpid(), SIGKILL);
    }
    errno = mode == EIO_MODE || mode == READ ? EIO : ENOSPC;
    return 1;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int opened(int fd, const char *path) {
    if (fd >= 0 && fd < FILES)
        tracked[fd] = below(path) ? 1 : 0;
    return fd;
}

static int may_not_open(const char *path, int flags) {
    if (!below(path) || !(flags & O_CREAT))
        return 0;
    return fails("open", path, -1, syscall(SYS_faccessat, AT_FDCWD, path, F_OK) != 0, 0);
}

#define OPEN(name)                                                                                                     \
    int name(const char *path, int flags, ...) {                                                                       \
        va_list more;                                                                                                  \
        va_start(more, flags);                                                                                         \
        mode_t rights = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0;                                      \
        va_end(more);                                                                                                  \
        if (may_not_open(path, flags))                                                                                 \
            return -1;                                                                                                 \
        return opened(REAL(name)(path, flags, rights), path);                                                          \
    }
OPEN(open)
OPEN(open64)

int close(int fd) {
    if (fd >= 0 && fd < FILES)
        tracked[fd] = 0;
    return REAL(close)(fd);
}

/* A full disk takes a part of what no longer fits. */
static size_t part(size_t size) {
    return mode == FULL && counted == target && size > 1 ? size / 2 : 0;
}

ssize_t write(int fd, const void *bytes, size_t size) {
    if (is_tracked(fd) && fails("write", NULL, fd, 1, 0)) {
        size_t some = part(size);
        return some ? REAL(write)(fd, bytes, some) : -1;
    }
    return REAL(write)(fd, bytes, size);
}

ssize_t writev(int fd, const struct iovec *parts, int count) {
    if (is_tracked(fd) && fails("writev", NULL, fd, 1, 0))
        return -1;
    return REAL(writev)(fd, parts, count);
}

#define PWRITE(name)                                                                                                   \
    ssize_t name(int fd, const void *bytes, size_t size, off64_t at) {         \
        if (is_tracked(fd) && fails("pwrite", NULL, fd, 1, 0)) {                                                       \
            size_t some = part(size);                                                                                  \
            return some ? REAL(name)(fd, bytes, some, at) : -1;                                                        \
        }                                                                                                              \
        return REAL(name)(fd, bytes, size, at);                                                                        \
    }
PWRITE(pwrite)
PWRITE(pwrite64)

#define READS(name, what, parameters, arguments)                                                                       \
    ssize_t name parameters {                                                                                          \
        if (is_tracked(fd) && fails(what, NULL, fd, 0, 1))                                                             \
            return -1;                                                                                                 \
        return REAL(name) arguments;                                                                                   \
    }
READS(read, "read", (int fd, void *bytes, size_t size), (fd, bytes, size))
READS(pread, "pread", (int fd, void *bytes, size_t size, off_t at), (fd, bytes, size, at))
READS(pread64, "pread", (int fd, void *bytes, size_t size, off64_t at), (fd, bytes, size, at))

#define ON_FILE(name, space, parameters, arguments)                                                                    \
    int name parameters {                                                                                              \
        if (is_tracked(fd) && fails(#name, NULL, fd, space, 0))                                                        \
            return -1;                                                                                                 \
        return REAL(name) arguments;                                                                                   \
    }
ON_FILE(ftruncate, 1, (int fd, off_t size), (fd, size))
ON_FILE(ftruncate64, 1, (int fd, off64_t size), (fd, size))
ON_FILE(fsync, 0, (int fd), (fd))
ON_FILE(fdatasync, 0, (int fd), (fd))
ON_FILE(fchmod, 0, (int fd, mode_t rights), (fd, rights))
ON_FILE(futimens, 0, (int fd, const struct timespec times[2]), (fd, times))

#define ON_PATH(name, space, parameters, arguments)                                                                    \
    int name parameters {                                                                                              \
        if (below(path) && fails(#name, path, -1, space, 0))                                                           \
            return -1;                                                                                                 \
        return REAL(name) arguments;                                                                                   \
    }
ON_PATH(rename, 0, (const char *path, const char *to), (path, to))
ON_PATH(mkdir, 1, (const char *path, mode_t rights), (path, rights))
ON_PATH(unlink, 0, (const char *path), (path))
ON_PATH(rmdir, 0, (const char *path), (path))
