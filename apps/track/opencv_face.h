/* opencv_face.h: all that talus-track has from OpenCV, behind a face of C.
 *
 * No exception passes: what fails answers NULL or -1, and the text says why.
 */
#ifndef OPENCV_FACE_H
#define OPENCV_FACE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define FACE_TEXT 300

/* A picture, blue, green, red; rows lie `stride` bytes apart. Good until the source's next one. */
struct face_picture {
  uint8_t *pixel;
  size_t stride;
  int width, height;
  double t_s; /* the frame's time by the file or the driver; by the nominal rate where those tell none */
};

struct face_video;
/* A file, or a camera: "camera:0". NULL, with the text. */
struct face_video *face_video_open(const char *path, char text[FACE_TEXT]);
/* 1 with the next picture, 0 at the end, -1 with the text. */
int face_video_next(struct face_video *video, struct face_picture *picture, char text[FACE_TEXT]);
/* How many pictures the file says it has (0 unknown), and its nominal rate [Hz]. */
double face_video_count(const struct face_video *video);
double face_video_rate(const struct face_video *video);
/* Nullable: video. */
void face_video_close(struct face_video *video);

/* A video of MJPEG pictures, all of one size. -1 with the text. */
struct face_writer;
struct face_writer *face_writer_open(const char *path, double rate_hz, int width, int height,
                                     char text[FACE_TEXT]);
void face_writer_add(struct face_writer *writer, const struct face_picture *picture);
void face_writer_close(struct face_writer *writer);

/* Drawing into a picture; colour is 0xRRGGBB. */
void face_circle(const struct face_picture *picture, double x, double y, double radius, unsigned color);
void face_line(const struct face_picture *picture, const double from[2], const double to[2], unsigned color);
void face_label(const struct face_picture *picture, double x, double y, const char *text, unsigned color);
/* `count` pictures of one size, the first `columns` in the top row, into a PNG or JPEG file. 0 or -1 with the text. */
int face_write_sheet(const char *path, const struct face_picture *picture, int count, int columns,
                     char text[FACE_TEXT]);

/* A lens: OpenCV's camera matrix and distortion. */
struct face_lens {
  double focal_px[2], center_px[2];
  double distortion[8]; /* k1 k2 p1 p2 k3 k4 k5 k6 */
  int width, height;    /* 0 unknown */
  double rms_px;        /* of the calibration, 0 unknown */
  int pictures;         /* in which the board was found */
};
/* From a file of cv::FileStorage with camera_matrix and distortion_coefficients. 0 or -1 with the text. */
int face_lens_read(const char *path, struct face_lens *lens, char text[FACE_TEXT]);
int face_lens_write(const char *path, const struct face_lens *lens, char text[FACE_TEXT]);
/* From pictures of a chessboard with columns by rows inner corners, `square` apart. found[count] says in which it was
 * seen. 0 or -1 with the text. */
int face_lens_calibrate(const char *const *path, int count, int columns, int rows, double square,
                        struct face_lens *lens, uint8_t *found, char text[FACE_TEXT]);
/* Points as a lens without distortion (focal_px[0] both ways) would show them, in place. */
void face_lens_undistort(const struct face_lens *lens, double (*point)[2], int count);

#ifdef __cplusplus
}
#endif
#endif
