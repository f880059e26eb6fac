/* What the standard library of Rust takes from a C library for WebAssembly and the one of Debian 12 does not have yet.
   There are no threads and no links, and files have no owner. */

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

int *__errno_location(void) { return &errno; }

int fchmod(int file, mode_t mode) { return 0; }

/* A path from the root, without `.` and `..`, if it names something. */
char *realpath(const char *path, char *resolved) {
    struct stat about;
    if (stat(path, &about) != 0) return NULL;
    char *whole = resolved ? resolved : malloc(PATH_MAX);
    size_t length = 0;
    if (!whole) return NULL;
    while (*path) {
        size_t part = strcspn(path, "/");
        if (part == 2 && !memcmp(path, "..", 2)) {
            while (length && whole[--length] != '/') {}
        } else if (part && !(part == 1 && *path == '.')) {
            if (length + part + 2 > PATH_MAX) return errno = ENAMETOOLONG, NULL;
            whole[length++] = '/';
            memcpy(whole + length, path, part);
            length += part;
        }
        path += part + (path[part] == '/');
    }
    if (!length) whole[length++] = '/';
    whole[length] = 0;
    return whole;
}

int pthread_attr_init(void *attributes) { return 0; }
int pthread_attr_destroy(void *attributes) { return 0; }
int pthread_attr_setstacksize(void *attributes, size_t size) { return 0; }
int pthread_create(void *thread, const void *attributes, void *(*start)(void *), void *argument) { return ENOTSUP; }
int pthread_join(void *thread, void **result) { return ENOTSUP; }
int pthread_detach(void *thread) { return ENOTSUP; }
