/* Faults of a machine, for a process that this library is preloaded into.
 *
 * TORTURE_FSYNC: microseconds that every flush to the disk, and every write for which it has no
 * room, takes longer.
 * TORTURE_CLOCK: a file with the seconds that the wall clock is ahead; read at every look.
 * TORTURE_READ_ONLY: a file; while it exists, nothing below TORTURE_FOLDER can be changed (EROFS).
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static void slow(void) {
    const char *wanted = getenv("TORTURE_FSYNC");
    if (wanted) usleep((useconds_t)atol(wanted));
}

int fsync(int file) {
    int (*real)(int) = dlsym(RTLD_NEXT, "fsync");
    slow();
    return real(file);
}

int fdatasync(int file) {
    int (*real)(int) = dlsym(RTLD_NEXT, "fdatasync");
    slow();
    return real(file);
}

static ssize_t after_a_while(ssize_t written) {
    if (written < 0 && errno == ENOSPC) {
        slow();
        errno = ENOSPC;
    }
    return written;
}

static long ahead(void) {
    const char *path = getenv("TORTURE_CLOCK");
    char text[32] = {0};
    int file = path ? open(path, O_RDONLY) : -1;
    if (file < 0) return 0;
    long found = read(file, text, sizeof text - 1) > 0 ? atol(text) : 0;
    close(file);
    return found;
}

int clock_gettime(clockid_t clock, struct timespec *now) {
    int (*real)(clockid_t, struct timespec *) = dlsym(RTLD_NEXT, "clock_gettime");
    int failed = real(clock, now);
    if (!failed && clock == CLOCK_REALTIME) now->tv_sec += ahead();
    return failed;
}

int gettimeofday(struct timeval *now, void *zone) {
    int (*real)(struct timeval *, void *) = dlsym(RTLD_NEXT, "gettimeofday");
    int failed = real(now, zone);
    if (!failed) now->tv_sec += ahead();
    return failed;
}

time_t time(time_t *place) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (place) *place = now.tv_sec;
    return now.tv_sec;
}

static int read_only(const char *path) {
    const char *when = getenv("TORTURE_READ_ONLY"), *folder = getenv("TORTURE_FOLDER");
    if (!when || !folder || strncmp(path, folder, strlen(folder)) || access(when, F_OK)) return 0;
    errno = EROFS;
    return 1;
}

static int read_only_file(int file) {
    char link[64], path[4096];
    if (!getenv("TORTURE_READ_ONLY")) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return read_only(path);
}

#define OPEN(name)                                                          \
    int name(const char *path, int flags, ...) {                            \
        int (*real)(const char *, int, ...) = dlsym(RTLD_NEXT, #name);      \
        va_list rest;                                                       \
        va_start(rest, flags);                                              \
        mode_t mode = va_arg(rest, mode_t);                                 \
        va_end(rest);                                                       \
        int changes = (flags & O_ACCMODE) != O_RDONLY || (flags & O_CREAT); \
        return changes && read_only(path) ? -1 : real(path, flags, mode);   \
    }
OPEN(open)
OPEN(open64)

#define WRITE(name, type, parameters, arguments)                                        \
    type name parameters {                                                              \
        type(*real) parameters = dlsym(RTLD_NEXT, #name);                               \
        return read_only_file(file) ? (type)-1 : (type)after_a_while(real arguments); \
    }
WRITE(write, ssize_t, (int file, const void *data, size_t size), (file, data, size))
WRITE(pwrite, ssize_t, (int file, const void *data, size_t size, off_t at), (file, data, size, at))
WRITE(pwrite64, ssize_t, (int file, const void *data, size_t size, off64_t at),
      (file, data, size, at))
WRITE(ftruncate, int, (int file, off_t size), (file, size))
WRITE(ftruncate64, int, (int file, off64_t size), (file, size))

#define CHANGE(name, parameters, arguments)                   \
    int name parameters {                                     \
        int(*real) parameters = dlsym(RTLD_NEXT, #name);      \
        return read_only(path) ? -1 : real arguments;         \
    }
CHANGE(unlink, (const char *path), (path))
CHANGE(rename, (const char *path, const char *target), (path, target))
CHANGE(mkdir, (const char *path, mode_t mode), (path, mode))
