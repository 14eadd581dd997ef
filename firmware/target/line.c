/* Two kinds of frames share the line. Every byte goes to both readers; whose check sum is right has been meant.
 * Damaged frames are answered in the monitor's way only while it is the monitor that is spoken to. */
#include "line.h"
#include "frames.h"
#include "link.h"
#include "loop.h"
#include "monitor.h"
#include "serial.h"

void line_serve(void)
{
    int is_monitor = 0;
    for (;;) {
        uint8_t byte = serial_read();
        int32_t length = frame_take(byte);
        if (length > 0 && monitor_take((uint32_t)length)) {
            is_monitor = 1;
            loop_stop(); /* its memory is the monitor's now */
        } else if (length == FRAME_DAMAGED && is_monitor) {
            monitor_refuse_damaged();
        }
        if (link_take(byte) && loop_take(link_frame.kind, link_frame.payload, link_frame.length))
            is_monitor = 0;
    }
}
