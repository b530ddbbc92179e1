/* opencv_face.cpp: see opencv_face.h. The one file that knows OpenCV. */
#include "track/opencv_face.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

namespace {

void say(char text[FACE_TEXT], const char *what) {
  std::snprintf(text, FACE_TEXT, "%s", what);
  for (char *c = text; *c; c++)
    if (*c == '\n') *c = ' ';
}

/* OpenCV's and FFmpeg's own messages stay away: what is wrong is said once, by the caller. */
void quiet() {
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0); /* AV_LOG_QUIET */
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
}

/* Runs f; an exception becomes its text and `failed`. */
template <class F, class R> R guarded(char text[FACE_TEXT], R failed, F f) {
  try {
    quiet();
    return f();
  } catch (const cv::Exception &e) {
    say(text, e.err.c_str());
  } catch (const std::exception &e) {
    say(text, e.what());
  } catch (...) {
    say(text, "unknown failure");
  }
  return failed;
}

cv::Mat view(const struct face_picture *p) {
  return cv::Mat(p->height, p->width, CV_8UC3, p->pixel, p->stride);
}

cv::Scalar scalar(unsigned color) {
  return cv::Scalar(color & 255, color >> 8 & 255, color >> 16 & 255);
}

cv::Point point(double x, double y) { /* in 1/16 px */
  return cv::Point(cvRound(16 * x), cvRound(16 * y));
}

cv::Mat matrix(const struct face_lens *lens) {
  return (cv::Mat_<double>(3, 3) << lens->focal_px[0], 0, lens->center_px[0], 0, lens->focal_px[1],
          lens->center_px[1], 0, 0, 1);
}

void from_mats(struct face_lens *lens, const cv::Mat &camera, const cv::Mat &distortion) {
  cv::Mat k, d;
  camera.convertTo(k, CV_64F);
  distortion.reshape(1, 1).convertTo(d, CV_64F);
  lens->focal_px[0] = k.at<double>(0, 0);
  lens->focal_px[1] = k.at<double>(1, 1);
  lens->center_px[0] = k.at<double>(0, 2);
  lens->center_px[1] = k.at<double>(1, 2);
  for (int i = 0; i < 8; i++) lens->distortion[i] = i < d.cols ? d.at<double>(0, i) : 0.0;
}

/* the board's corners in a picture, to sub-pixels */
bool corners_of(const cv::Mat &gray, cv::Size board, std::vector<cv::Point2f> &corner) {
  if (!cv::findChessboardCorners(gray, board, corner)) return false;
  const cv::TermCriteria until(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 30, 0.01);
  cv::cornerSubPix(gray, corner, cv::Size(11, 11), cv::Size(-1, -1), until);
  return true;
}

std::vector<cv::Point3f> board_points(cv::Size board, double square) {
  std::vector<cv::Point3f> point;
  for (int y = 0; y < board.height; y++)
    for (int x = 0; x < board.width; x++) point.emplace_back(float(x * square), float(y * square), 0.0F);
  return point;
}

int calibrate(const char *const *path, int count, cv::Size board, double square, struct face_lens *lens,
              uint8_t *found, char text[FACE_TEXT]) {
  std::vector<std::vector<cv::Point2f>> image;
  cv::Size size;
  for (int i = 0; i < count; i++) {
    std::vector<cv::Point2f> corner;
    const cv::Mat gray = cv::imread(path[i], cv::IMREAD_GRAYSCALE);
    if (gray.empty() || (size.width && gray.size() != size)) {
      std::snprintf(text, FACE_TEXT, "%.200s: %s", path[i],
                    gray.empty() ? "no picture that can be read" : "another size than the first");
      return -1;
    }
    size = gray.size();
    found[i] = corners_of(gray, board, corner);
    if (found[i]) image.push_back(corner);
  }
  lens->pictures = int(image.size());
  if (lens->pictures < 3) {
    std::snprintf(text, FACE_TEXT,
                  "the board of %d by %d inner corners was found in %d of %d pictures, expected "
                  "3 or more",
                  board.width, board.height, lens->pictures, count);
    return -1;
  }
  cv::Mat camera, distortion;
  std::vector<cv::Mat> turn, shift;
  const std::vector<std::vector<cv::Point3f>> object(image.size(), board_points(board, square));
  lens->rms_px = cv::calibrateCamera(object, image, size, camera, distortion, turn, shift);
  lens->width = size.width;
  lens->height = size.height;
  from_mats(lens, camera, distortion);
  return 0;
}

} // namespace

struct face_video {
  cv::VideoCapture capture;
  cv::Mat frame;
  double rate_hz, last_s;
  long frames;
};

struct face_writer {
  cv::VideoWriter writer;
};

face_video *face_video_open(const char *path, char text[FACE_TEXT]) {
  return guarded(text, static_cast<face_video *>(nullptr), [&]() -> face_video * {
    auto *video = new face_video;
    if (std::strncmp(path, "camera:", 7) == 0)
      video->capture.open(std::atoi(path + 7));
    else
      video->capture.open(path, cv::CAP_FFMPEG); // others look for cameras in a file that is no video
    if (!video->capture.isOpened()) {
      delete video;
      say(text, "no video that can be opened");
      return nullptr;
    }
    video->rate_hz = video->capture.get(cv::CAP_PROP_FPS);
    video->last_s = -1.0;
    video->frames = 0;
    return video;
  });
}

int face_video_next(face_video *video, face_picture *picture, char text[FACE_TEXT]) {
  return guarded(text, -1, [&]() -> int {
    if (!video->capture.read(video->frame) || video->frame.empty()) return 0;
    if (video->frame.type() != CV_8UC3) {
      say(text, "its pictures are not 8 bits of blue, green and red");
      return -1;
    }
    double t_s = 1e-3 * video->capture.get(cv::CAP_PROP_POS_MSEC);
    if (!(t_s > video->last_s)) /* no time of its own: go on at the nominal rate */
      t_s = video->last_s + (video->rate_hz > 0 ? 1.0 / video->rate_hz : 1.0 / 30.0);
    if (video->frames++ == 0 && !(t_s >= 0.0)) t_s = 0.0;
    video->last_s = t_s;
    *picture = face_picture{video->frame.data, video->frame.step, video->frame.cols, video->frame.rows, t_s};
    return 1;
  });
}

double face_video_count(const face_video *video) {
  const double count = video->capture.get(cv::CAP_PROP_FRAME_COUNT);
  return count > 0 ? count : 0.0;
}

double face_video_rate(const face_video *video) {
  return video->rate_hz;
}

void face_video_close(face_video *video) {
  delete video;
}

face_writer *face_writer_open(const char *path, double rate_hz, int width, int height, char text[FACE_TEXT]) {
  return guarded(text, static_cast<face_writer *>(nullptr), [&]() -> face_writer * {
    auto *writer = new face_writer;
    const int code = cv::VideoWriter::fourcc('M', 'J', 'P', 'G');
    if (writer->writer.open(path, code, rate_hz > 0 ? rate_hz : 30.0, cv::Size(width, height))) return writer;
    delete writer;
    say(text, "cannot be written as a video (a name that ends in .avi or .mkv?)");
    return nullptr;
  });
}

void face_writer_add(face_writer *writer, const face_picture *picture) {
  char text[FACE_TEXT];
  guarded(text, -1, [&]() -> int {
    writer->writer.write(view(picture));
    return 0;
  });
}

void face_writer_close(face_writer *writer) {
  delete writer;
}

void face_circle(const face_picture *picture, double x, double y, double radius, unsigned color) {
  cv::Mat m = view(picture);
  cv::circle(m, point(x, y), cvRound(16 * radius), scalar(color), 2, cv::LINE_AA, 4);
}

void face_line(const face_picture *picture, const double from[2], const double to[2], unsigned color) {
  cv::Mat m = view(picture);
  cv::line(m, point(from[0], from[1]), point(to[0], to[1]), scalar(color), 1, cv::LINE_AA, 4);
}

void face_label(const face_picture *picture, double x, double y, const char *text, unsigned color) {
  cv::Mat m = view(picture);
  const cv::Point at(cvRound(x), cvRound(y));
  cv::putText(m, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.6, scalar(0), 3, cv::LINE_AA);
  cv::putText(m, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.6, scalar(color), 1, cv::LINE_AA);
}

int face_write_sheet(const char *path, const face_picture *picture, int count, int columns,
                     char text[FACE_TEXT]) {
  return guarded(text, -1, [&]() -> int {
    const int rows = (count + columns - 1) / columns, w = picture[0].width, h = picture[0].height;
    cv::Mat sheet(rows * h, columns * w, CV_8UC3, cv::Scalar::all(255));
    for (int i = 0; i < count; i++)
      view(&picture[i]).copyTo(sheet(cv::Rect((i % columns) * w, (i / columns) * h, w, h)));
    if (cv::imwrite(path, sheet)) return 0;
    say(text, "cannot be written");
    return -1;
  });
}

int face_lens_read(const char *path, face_lens *lens, char text[FACE_TEXT]) {
  return guarded(text, -1, [&]() -> int {
    cv::FileStorage file(path, cv::FileStorage::READ);
    cv::Mat camera, distortion;
    *lens = face_lens{};
    if (file.isOpened()) {
      file["camera_matrix"] >> camera;
      file["distortion_coefficients"] >> distortion;
      if (!file["image_width"].empty()) lens->width = int(file["image_width"]);
      if (!file["image_height"].empty()) lens->height = int(file["image_height"]);
      if (!file["avg_reprojection_error"].empty()) lens->rms_px = double(file["avg_reprojection_error"]);
    }
    if (camera.rows != 3 || camera.cols != 3 || distortion.total() < 4 || distortion.total() > 8) {
      say(text,
          "no calibration of OpenCV: expected camera_matrix (3 by 3) and distortion_coefficients (4 to 8)");
      return -1;
    }
    from_mats(lens, camera, distortion);
    return 0;
  });
}

int face_lens_write(const char *path, const face_lens *lens, char text[FACE_TEXT]) {
  return guarded(text, -1, [&]() -> int {
    cv::FileStorage file(path, cv::FileStorage::WRITE | cv::FileStorage::FORMAT_YAML);
    if (!file.isOpened()) {
      say(text, "cannot be written");
      return -1;
    }
    /* calibrateCamera's order: k1 k2 p1 p2 k3 */
    file << "image_width" << lens->width << "image_height" << lens->height << "pictures" << lens->pictures;
    file << "camera_matrix" << matrix(lens);
    file << "distortion_coefficients" << cv::Mat(1, 5, CV_64F, const_cast<double *>(lens->distortion));
    file << "avg_reprojection_error" << lens->rms_px;
    return 0;
  });
}

int face_lens_calibrate(const char *const *path, int count, int columns, int rows, double square,
                        face_lens *lens, uint8_t *found, char text[FACE_TEXT]) {
  *lens = face_lens{};
  return guarded(text, -1, [&]() -> int {
    return calibrate(path, count, cv::Size(columns, rows), square, lens, found, text);
  });
}

void face_lens_undistort(const face_lens *lens, double (*point)[2], int count) {
  char text[FACE_TEXT];
  guarded(text, -1, [&]() -> int {
    std::vector<cv::Point2d> in, out;
    for (int i = 0; i < count; i++) in.emplace_back(point[i][0], point[i][1]);
    const cv::Mat distortion(1, 8, CV_64F, const_cast<double *>(lens->distortion));
    /* more rounds than the default five, whose rest can be a tenth of a pixel at the picture's corners */
    const cv::TermCriteria until(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 40, 1e-9);
    cv::undistortPoints(in, out, matrix(lens), distortion, cv::noArray(), cv::noArray(), until);
    for (int i = 0; i < count; i++) {
      point[i][0] = out[i].x * lens->focal_px[0] + lens->center_px[0];
      point[i][1] = out[i].y * lens->focal_px[0] + lens->center_px[1];
    }
    return 0;
  });
}
