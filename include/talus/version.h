/* version.h: which talus this is, at compile time and at run time.
 *
 * A program that was compiled against one version and runs with another can
 * tell by comparing TL_VERSION with tl_version().
 *
 *     if (strcmp(TL_VERSION, tl_version()) != 0) puts("compiled against another version");
 */
#ifndef TALUS_VERSION_H
#define TALUS_VERSION_H

#ifdef __cplusplus
extern "C" {
#endif

#define TL_VERSION_MAJOR 0
#define TL_VERSION_MINOR 1
#define TL_VERSION_PATCH 0

#define TL_VERSION_JOIN_(a, b, c) #a "." #b "." #c
#define TL_VERSION_TEXT_(a, b, c) TL_VERSION_JOIN_(a, b, c)
/* The headers' version as text, "0.1.0". */
#define TL_VERSION TL_VERSION_TEXT_(TL_VERSION_MAJOR, TL_VERSION_MINOR, TL_VERSION_PATCH)

/* The version of the library that is linked, such as "0.1.0"; never NULL. */
const char *tl_version(void);

#ifdef __cplusplus
}
#endif
#endif
