/* A signed model at start: it is read only if an accepted key has signed it and it is not older than the last one.
 *
 * The model of the standard rig is signed with a key of the tests. `cargo xtask c` builds this file with the library's
 * feature `signature` as C and as C++, runs it in QEMU, and compares every line with what the Rust example `signed`
 * prints on the host. */
#define BEARING_WATCH_SIGNATURE
#include "bearing_watch_service.h"
#include "board.h"
#include "print.h"

#ifdef __cplusplus
extern "C" {
#endif
extern const uint8_t signed_start[], signed_end[];
#ifdef __cplusplus
}
#endif

/* As `bearing-watch sign --key FILE` prints it. */
static const uint8_t key[BW_KEY_SIZE] = {
    0x8a, 0x88, 0xe3, 0xdd, 0x74, 0x09, 0xf1, 0x95,
    0xfd, 0x52, 0xdb, 0x2d, 0x3c, 0xba, 0x5d, 0x72,
    0xca, 0x67, 0x09, 0xbf, 0x1d, 0x94, 0x12, 0x1b,
    0xf3, 0x74, 0x88, 0x01, 0xb4, 0x0f, 0x6f, 0x5c,
};
/* Counter of the newest model that has run. A drive stores it in memory that cannot be set back. */
#define LEAST_COUNTER 5u

/* A copy of the flash that is changed; what follows the signature is erased. */
static uint8_t sector[4096];
static uint64_t memory[BW_STATE_SIZE / sizeof(uint64_t)];

/* Not used: there is no drive. */
void SysTick_Handler(void) {}

static void verify(const char *what, size_t length, const uint8_t (*keys)[BW_KEY_SIZE], uint32_t least) {
    BwSigned model = {0, 0, 0};
    BwCode code = bw_verify_model(sector, length, keys, 1, least, &model);
    if (code < 0) {
        printf("%s: %s\n", what, bw_error_text(code));
        return;
    }
    BwState *detector;
    code = bw_start(memory, sizeof memory, sector, model.model_length, NULL, &detector);
    printf("%s: model of %lu bytes, counter %lu, %s\n", what, (unsigned long)model.model_length,
           (unsigned long)model.counter, code < 0 ? bw_error_text(code) : "read");
}

int main(void) {
    static const uint8_t other[BW_KEY_SIZE] = {7};
    size_t length = (size_t)(signed_end - signed_start);
    memset(sector, 0xFF, sizeof sector);
    memcpy(sector, signed_start, length);
    verify("flash", sizeof sector, &key, LEAST_COUNTER);
    verify("next counter", sizeof sector, &key, LEAST_COUNTER + 1);
    verify("other key", sizeof sector, &other, LEAST_COUNTER);
    verify("cut short", length - 1, &key, LEAST_COUNTER);
    sector[100] ^= 1;
    verify("changed model", sizeof sector, &key, LEAST_COUNTER);
    sector[100] ^= 1;
    sector[length - 1] ^= 1;
    verify("changed signature", sizeof sector, &key, LEAST_COUNTER);
    return 0;
}
