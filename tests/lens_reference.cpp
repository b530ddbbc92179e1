/* lens_reference.cpp: OpenCV's own calibration of chessboard pictures, as its manual does it; prints the reprojection error,
 * focal lengths and centre. lens_reference COLUMNS ROWS PICTURE... */
#include <cstdio>
#include <cstdlib>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

int main(int argc, char **argv) {
  const cv::Size board(std::atoi(argv[1]), std::atoi(argv[2]));
  std::vector<std::vector<cv::Point2f>> seen;
  std::vector<std::vector<cv::Point3f>> real;
  std::vector<cv::Point3f> grid;
  cv::Size size;
  for (int i = 0; i < board.area(); i++)
    grid.push_back(cv::Point3f(float(i % board.width), float(i / board.width), 0));
  for (int i = 3; i < argc; i++) {
    cv::Mat picture = cv::imread(argv[i], cv::IMREAD_GRAYSCALE);
    std::vector<cv::Point2f> corners;
    size = picture.size();
    if (!cv::findChessboardCorners(picture, board, corners)) continue;
    cv::cornerSubPix(picture, corners, cv::Size(11, 11), cv::Size(-1, -1), cv::TermCriteria(3, 30, 0.01));
    seen.push_back(corners);
    real.push_back(grid);
  }
  cv::Mat camera, distortion;
  std::vector<cv::Mat> turns, shifts;
  const double error = cv::calibrateCamera(real, seen, size, camera, distortion, turns, shifts);
  std::printf("%.15g %.15g %.15g %.15g %.15g\n", error, camera.at<double>(0, 0), camera.at<double>(1, 1),
              camera.at<double>(0, 2), camera.at<double>(1, 2));
  return 0;
}
