/* Kills the process at its KILL_AT-th write to a file whose name ends in KILL_FILE: that write is not done. With KILL_AT = 0 the number
 * of writes goes to the file KILL_COUNT when the process ends. Loaded before the C library (LD_PRELOAD); see test_killed_at_a_write.py. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static long writes = 0;

static int is_meant(int descriptor)
{
    char link[64], path[4096];
    const char *end = getenv("KILL_FILE");
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (end == NULL || length < (ssize_t)strlen(end))
        return 0;
    path[length] = '\0';
    return strcmp(path + length - strlen(end), end) == 0;
}

static void count(int descriptor)
{
    const char *at = getenv("KILL_AT");
    if (at == NULL || !is_meant(descriptor))
        return;
    writes++;
    if (writes == atol(at))
        kill(getpid(), SIGKILL);
}

ssize_t write(int descriptor, const void *bytes, size_t length)
{
    static ssize_t (*real)(int, const void *, size_t) = NULL;
    if (real == NULL)
        real = (ssize_t(*)(int, const void *, size_t))dlsym(RTLD_NEXT, "write");
    count(descriptor);
    return real(descriptor, bytes, length);
}

ssize_t pwrite(int descriptor, const void *bytes, size_t length, off_t offset)
{
    static ssize_t (*real)(int, const void *, size_t, off_t) = NULL;
    if (real == NULL)
        real = (ssize_t(*)(int, const void *, size_t, off_t))dlsym(RTLD_NEXT, "pwrite");
    count(descriptor);
    return real(descriptor, bytes, length, offset);
}

ssize_t pwrite64(int descriptor, const void *bytes, size_t length, off64_t offset)
{
    static ssize_t (*real)(int, const void *, size_t, off64_t) = NULL;
    if (real == NULL)
        real = (ssize_t(*)(int, const void *, size_t, off64_t))dlsym(RTLD_NEXT, "pwrite64");
    count(descriptor);
    return real(descriptor, bytes, length, offset);
}

__attribute__((destructor)) static void tell(void)
{
    const char *path = getenv("KILL_COUNT");
    FILE *file = path == NULL ? NULL : fopen(path, "w");
    if (file == NULL)
        return;
    fprintf(file, "%ld\n", writes);
    fclose(file);
}
