// A control loop in C++, with a class that closes its reader and a point as a std::optional.
//
//     c++ -std=c++17 follow.cpp $(pkg-config --cflags --libs lariat) -o follow
//
// or by CMake: see CMakeLists.txt. Arguments: the rig, and after how many frames to end.

#include <lariat.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>

using Point = std::array<double, 2>;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;

class Reader {
  public:
    explicit Reader(const char *rig) {
        lariat_reader *opened;
        check(lariat_open(rig, &opened));
        reader.reset(opened);
    }

    // Returns true if a new frame came.
    bool wait(nanoseconds timeout) { return check(lariat_wait(reader.get(), timeout.count())) > 0; }

    // Returns a point of the only rope, if it is completely visible in an image no older than
    // max_age.
    std::optional<Point> point(double rho, nanoseconds max_age) {
        Point at;
        known = lariat_only_rope(reader.get(), max_age.count(), &rope);
        if (known != LARIAT_FRESH) return std::nullopt;
        check(lariat_point_at(rope.fresh, rho, at.data()));
        return at;
    }

    const char *why() const { return lariat_seen_text(known); }

  private:
    struct Close {
        void operator()(lariat_reader *open) const { lariat_close(open); }
    };

    static int check(int answer) {
        if (answer < 0) throw std::runtime_error(lariat_error());
        return answer;
    }

    std::unique_ptr<lariat_reader, Close> reader;
    lariat_rope rope;
    lariat_seen known = LARIAT_NOTHING_YET;
};

int main(int count, char **arguments) try {
    Reader reader(count > 1 ? arguments[1] : "default");
    long frames = count > 2 ? std::atol(arguments[2]) : -1;
    while (frames != 0) {
        frames -= reader.wait(50ms);
        if (auto at = reader.point(0.5, 100ms))
            std::cout << "move " << 320 - (*at)[0] << ' ' << 240 - (*at)[1] << " px/s\n";
        else
            std::cout << "hold: " << reader.why() << '\n';
    }
} catch (const std::exception &cause) {
    std::cerr << "follow: " << cause.what() << '\n';
    return 1;
}
