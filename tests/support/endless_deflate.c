/* SPDX-License-Identifier: BSD-3-Clause */
/* Preloaded into a program, this lets the compression of a PNG file last for ever, so that a test
 * can stop the program while it compresses. */
#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

int deflate(void *stream, int flush);

/* In the place of zlib's function: makes the file that the variable DEFLATE_BEGINS names, and never
 * returns. */
int deflate(void *stream, int flush)
{
    close(open(getenv("DEFLATE_BEGINS"), O_WRONLY | O_CREAT, 0600));
    for (;;)
        pause();
}
