#include "cli/watch_terminal.h"

#include "cli/load.h"
#include "watch/save.h"
#include "watch/terminal.h"

#include <errno.h>
#include <poll.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <termios.h>
#include <unistd.h>

enum { LOOK_MS = 50 }; // between looks for news

typedef struct Screen {
    const Options *options;
    Session *session;
    Terminal *terminal;
    struct termios before;
    int signals; // a signalfd
    SessionNews seen;
    bool whole, stale, quit;
    char keys[64];
    size_t key_count;
} Screen;

// All of it, or as much as a terminal that has gone away takes.
static void put(Text *text)
{
    size_t done = 0;
    while (!text->failed && done < text->length) {
        ssize_t part = write(STDOUT_FILENO, text->bytes + done, text->length - done);
        if (part < 0 && errno != EINTR) {
            break;
        }
        done += part > 0 ? (size_t)part : 0;
    }
    text_free(text);
}

static TerminalSize screen_size(void)
{
    struct winsize window = {0};
    ioctl(STDOUT_FILENO, TIOCGWINSZ, &window);
    return (TerminalSize){window.ws_col ? window.ws_col : 80, window.ws_row ? window.ws_row : 24,
                          window.ws_xpixel, window.ws_ypixel};
}

// --- Saving --------------------------------------------------------------------------------------

static bool write_file(const char *path, const FileBytes *bytes, char *message, size_t message_size)
{
    AtomicFile file;
    if (!atomic_file_open(&file, path, message, message_size)) {
        return false;
    }
    fwrite(bytes->bytes, 1, bytes->size, file.stream);
    return atomic_file_commit(&file, message, message_size);
}

// scene.scn -> scene.png
static void save(Screen *screen)
{
    char path[4096], message[500] = "there is no picture yet";
    const char *name = screen->options->operand, *dot = strrchr(name, '.');
    int length = dot && !strchr(dot, '/') && dot > name ? (int)(dot - name) : (int)strlen(name);
    snprintf(path, sizeof path, "%.*s.png", length, name);
    SessionLook look;
    Snapshot *picture = session_picture(screen->session, &look);
    FileBytes *bytes = picture ? save_picture(picture, look, "png", message, sizeof message) : NULL;
    if (bytes && write_file(path, bytes, message, sizeof message)) {
        snprintf(message, sizeof message, "saved as %.400s", path);
    }
    if (bytes) {
        save_release(bytes);
    }
    snapshot_release(picture);
    terminal_say(screen->terminal, message);
}

// --- The loop ------------------------------------------------------------------------------------

static void read_keys(Screen *screen)
{
    ssize_t count = read(STDIN_FILENO, screen->keys + screen->key_count,
                         sizeof screen->keys - screen->key_count);
    if (count <= 0) {
        screen->quit = count == 0 || errno != EINTR;
        return;
    }
    screen->key_count += (size_t)count;
    size_t used = 0;
    for (TerminalWish wish = WISH_REDRAW; wish != WISH_NOTHING && !screen->quit;) {
        wish = terminal_keys(screen->terminal, screen->keys, screen->key_count, &used);
        memmove(screen->keys, screen->keys + used, screen->key_count - used);
        screen->key_count -= used;
        screen->stale |= wish != WISH_NOTHING;
        screen->quit = wish == WISH_QUIT;
        if (wish == WISH_SAVE) {
            save(screen);
        }
    }
    if (screen->key_count == sizeof screen->keys) {
        screen->key_count = 0; // no key is that long
    }
}

static void read_signal(Screen *screen)
{
    struct signalfd_siginfo info;
    if (read(screen->signals, &info, sizeof info) == (ssize_t)sizeof info) {
        bool resized = info.ssi_signo == SIGWINCH;
        screen->whole |= resized;
        screen->quit |= !resized;
    }
}

static void show(Screen *screen)
{
    SessionNews before = screen->seen;
    session_wait(screen->session, &screen->seen, 0);
    if (memcmp(&before, &screen->seen, sizeof before) != 0 || screen->stale || screen->whole) {
        bool whole = screen->whole || before.scene != screen->seen.scene;
        Text text = {0};
        screen->whole = screen->stale = false;
        terminal_draw(screen->terminal, screen_size(), whole, &text);
        put(&text);
    }
}

static void run(Screen *screen)
{
    struct pollfd fds[2] = {{STDIN_FILENO, POLLIN, 0}, {screen->signals, POLLIN, 0}};
    while (!screen->quit) {
        show(screen);
        poll(fds, 2, LOOK_MS);
        if (fds[1].revents) {
            read_signal(screen);
        }
        if (fds[0].revents && !screen->quit) {
            read_keys(screen);
        }
    }
}

static bool make_raw(Screen *screen)
{
    if (tcgetattr(STDIN_FILENO, &screen->before) != 0) {
        return false;
    }
    struct termios raw = screen->before;
    raw.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
    raw.c_cc[VMIN] = 1;
    raw.c_cc[VTIME] = 0;
    return tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
}

static void on_screen(Screen *screen)
{
    Text text = {0};
    terminal_enter(&text);
    put(&text);
    run(screen);
    terminal_leave(&text);
    put(&text);
    tcsetattr(STDIN_FILENO, TCSANOW, &screen->before);
    // What was found by hand isn't lost.
    Text command = session_command(screen->session), camera = session_camera_text(screen->session);
    if (!screen->options->quiet && command.bytes) {
        printf("%s\n%s%s", command.bytes, camera.bytes ? camera.bytes : "",
               camera.length > 0 ? "\n" : "");
    }
    text_free(&command);
    text_free(&camera);
}

int watch_on_terminal(const Options *options, Session *session, const sigset_t *signals)
{
    char message[500];
    Screen screen = {.options = options, .session = session, .whole = true};
    if (!isatty(STDIN_FILENO) || !isatty(STDOUT_FILENO)) {
        return complain(EXIT_USAGE, "`--terminal` wants to run on a terminal");
    }
    screen.terminal = terminal_new(session, options->terminal, message, sizeof message);
    if (!screen.terminal) {
        return complain(EXIT_USAGE, "%s", message);
    }
    sigset_t all = *signals;
    sigaddset(&all, SIGWINCH);
    pthread_sigmask(SIG_BLOCK, &all, NULL);
    screen.signals = signalfd(-1, &all, SFD_CLOEXEC | SFD_NONBLOCK);
    int code = EXIT_OK;
    if (screen.signals < 0 || !make_raw(&screen)) {
        code = complain(EXIT_FILES, "the terminal can't be used: %s", strerror(errno));
    } else {
        on_screen(&screen);
    }
    pthread_sigmask(SIG_UNBLOCK, signals, NULL); // a second one doesn't wait for what ends
    if (screen.signals >= 0) {
        close(screen.signals);
    }
    terminal_free(screen.terminal);
    return code;
}
