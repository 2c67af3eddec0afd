// What the whole server holds in memory while a client sends it a gigabyte.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/child_process.h"
#include "tests/support/raw_http.h"
#include "tests/support/temporary_folder.h"

namespace morphograph {
namespace {

constexpr std::size_t kGigabyte = std::size_t{1} << 30;
// Far below the gigabyte; above what threads, buffers and a sanitizer's own books take.
constexpr double kMostGrowthMib = 96;

// Sends a body as fast as the server takes it. @return the answer's status, 0 when there was none.
int StatusOfAGigabyte(int port, const std::string& target, bool chunked) {
  testing::RawConnection connection(port);
  connection.Send("POST " + target + " HTTP/1.1\r\nHost: test\r\n" +
                  (chunked ? "Transfer-Encoding: chunked\r\n\r\n"
                           : "Content-Length: " + std::to_string(kGigabyte) + "\r\n\r\n"));
  const std::string block(1 << 20, ' ');
  for (std::size_t sent = 0; sent < kGigabyte; sent += block.size())
    if (!connection.Send(chunked ? "100000\r\n" + block + "\r\n" : block)) break;
  return connection.Read().value_or(testing::RawResponse{}).status;
}

TEST(ServerMemory, AGigabyteIsRefusedAndNotHeld) {
  testing::TemporaryFolder folder;
  testing::ChildProcess server("'" MORPHOGRAPH_PROGRAM "' serve --port 0 --threads 2 --data-dir '" + folder.path().string() + "'");
  const int port = testing::ServedPort(&server);
  // What it needs for plain work is not what is measured.
  ASSERT_EQ(testing::Ask(port, "POST", "/v1/clips", "", R"({"model": "walk", "seed": 1, "duration": 60})").status, 200);
  const double before = server.PeakMemoryMib();
  for (const std::string target : {"/v1/clips", "/v1/evaluations", "/v1/models"}) {
    EXPECT_EQ(StatusOfAGigabyte(port, target, /*chunked=*/false), 413) << target;
    EXPECT_EQ(StatusOfAGigabyte(port, target, /*chunked=*/true), 411) << target;
    EXPECT_LT(server.PeakMemoryMib() - before, kMostGrowthMib) << target;
  }
  EXPECT_EQ(testing::Ask(port, "GET", "/livez").status, 200);
}

}  // namespace
}  // namespace morphograph
