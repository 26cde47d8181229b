#include "watch/tev.h"

#include "base/mem.h"

#include <errno.h>
#include <netdb.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { CREATE_IMAGE = 4, UPDATE_IMAGE_V3 = 6, CHANNELS = 3 };
enum { SEND_SECONDS = 5, RETRY_MS = 500 };
enum { MOST_PACKET_FLOATS = 4 << 20 };

struct TevSender {
    Session *session;
    const char *name;
    char host[256], port[16];
    pthread_t thread;
};

// --- Packets -------------------------------------------------------------------------------------

static void add_integer(Text *packet, int64_t value, int bytes)
{
    for (int i = 0; i < bytes; ++i) {
        char byte = (char)(uint64_t)(value >> 8 * i & 0xff);
        text_write(packet, &byte, 1);
    }
}

static void add_string(Text *packet, const char *text)
{
    text_write(packet, text, strlen(text) + 1);
}

static void add_head(Text *packet, int type, const char *name, bool focus)
{
    add_integer(packet, 0, 4); // the length, known in the end
    add_integer(packet, type, 1);
    add_integer(packet, focus, 1);
    add_string(packet, name);
}

static void add_channel_names(Text *packet)
{
    add_integer(packet, CHANNELS, 4);
    add_string(packet, "R");
    add_string(packet, "G");
    add_string(packet, "B");
}

static void set_length(Text *packet)
{
    for (int i = 0; !packet->failed && i < 4; ++i) {
        packet->bytes[i] = (char)(packet->length >> 8 * i & 0xff);
    }
}

void tev_create_image(Text *packet, const char *name, bool focus, uint32_t width, uint32_t height)
{
    add_head(packet, CREATE_IMAGE, name, focus);
    add_integer(packet, width, 4);
    add_integer(packet, height, 4);
    add_channel_names(packet);
    set_length(packet);
}

static void add_float(Text *packet, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    add_integer(packet, bits, 4);
}

void tev_update_image(Text *packet, const char *name, uint32_t width, uint32_t first, uint32_t rows,
                      const float *radiance)
{
    add_head(packet, UPDATE_IMAGE_V3, name, false);
    add_channel_names(packet);
    const int64_t area[] = {0, first, width, rows};
    for (int i = 0; i < 4; ++i) {
        add_integer(packet, area[i], 4);
    }
    for (int i = 0; i < CHANNELS; ++i) { // offsets, in floats
        add_integer(packet, i, 8);
    }
    for (int i = 0; i < CHANNELS; ++i) { // and strides
        add_integer(packet, CHANNELS, 8);
    }
    size_t count = (size_t)CHANNELS * width * rows;
    if (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) {
        text_write(packet, (const char *)radiance, count * sizeof *radiance);
    } else {
        for (size_t i = 0; i < count; ++i) {
            add_float(packet, radiance[i]);
        }
    }
    set_length(packet);
}

// --- Sending -------------------------------------------------------------------------------------

static bool send_packet(int fd, Text *packet)
{
    size_t sent = 0;
    while (!packet->failed && sent < packet->length) {
        ssize_t part = send(fd, packet->bytes + sent, packet->length - sent, MSG_NOSIGNAL);
        if (part <= 0 && errno != EINTR) {
            break;
        }
        sent += part > 0 ? (size_t)part : 0;
    }
    bool whole = !packet->failed && sent == packet->length;
    text_free(packet);
    return whole;
}

static int connect_to(const TevSender *sender)
{
    struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM}, *found = NULL;
    if (getaddrinfo(sender->host, sender->port, &hints, &found) != 0) {
        return -1;
    }
    int fd = -1;
    for (const struct addrinfo *at = found; at && fd < 0; at = at->ai_next) {
        fd = socket(at->ai_family, at->ai_socktype | SOCK_CLOEXEC, at->ai_protocol);
        struct timeval limit = {.tv_sec = SEND_SECONDS}; // of connecting, too
        if (fd >= 0 && (setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit) != 0 ||
                        connect(fd, at->ai_addr, at->ai_addrlen) != 0)) {
            close(fd);
            fd = -1;
        }
    }
    freeaddrinfo(found);
    return fd;
}

// tev says nothing: what can be read is its end.
static bool is_gone(int fd)
{
    char byte;
    return recv(fd, &byte, 1, MSG_DONTWAIT | MSG_PEEK) == 0;
}

typedef struct Sent {
    int fd; // -1: not connected
    uint32_t width, height;
    uint64_t number;
} Sent;

static bool send_picture(const TevSender *sender, Sent *sent, const Snapshot *picture)
{
    Text packet = {0};
    if (picture->width != sent->width || picture->height != sent->height) {
        tev_create_image(&packet, sender->name, sent->width == 0, picture->width, picture->height);
        if (!send_packet(sent->fd, &packet)) {
            return false;
        }
        sent->width = picture->width;
        sent->height = picture->height;
    }
    uint32_t rows = MOST_PACKET_FLOATS / (CHANNELS * picture->width + 1) + 1;
    for (uint32_t first = 0; first < picture->height; first += rows) {
        uint32_t left = picture->height - first, part = left < rows ? left : rows;
        tev_update_image(&packet, sender->name, picture->width, first, part,
                         picture->radiance + (size_t)CHANNELS * picture->width * first);
        if (!send_packet(sent->fd, &packet)) {
            return false;
        }
    }
    sent->number = picture->number;
    return true;
}

static void disconnect(Sent *sent)
{
    if (sent->fd >= 0) {
        close(sent->fd);
    }
    *sent = (Sent){.fd = -1};
}

static void bring_up_to_date(const TevSender *sender, Sent *sent)
{
    SessionLook look;
    Snapshot *picture = session_picture(sender->session, &look);
    if (sent->fd >= 0 && is_gone(sent->fd)) {
        disconnect(sent);
    }
    // A coarse picture would make it another size for a moment.
    if (picture && !picture->coarse && picture->number != sent->number) {
        sent->fd = sent->fd >= 0 ? sent->fd : connect_to(sender);
        if (sent->fd >= 0 && !send_picture(sender, sent, picture)) {
            disconnect(sent);
        }
    }
    snapshot_release(picture);
}

static void *send_pictures(void *context)
{
    const TevSender *sender = context;
    Sent sent = {.fd = -1};
    SessionNews seen = {0};
    while (session_wait(sender->session, &seen, RETRY_MS)) {
        bring_up_to_date(sender, &sent);
    }
    disconnect(&sent);
    return NULL;
}

// --- Beginning and end ---------------------------------------------------------------------------

// "host:port" or "[::1]:port"
static bool take_address(TevSender *sender, const char *address)
{
    const char *colon = strrchr(address, ':');
    if (!colon || colon == address || !colon[1] || strlen(colon + 1) >= sizeof sender->port ||
        strspn(colon + 1, "0123456789") != strlen(colon + 1)) {
        return false;
    }
    size_t length = (size_t)(colon - address);
    bool bracketed = address[0] == '[' && address[length - 1] == ']';
    address += bracketed;
    length -= bracketed ? 2 : 0;
    if (length == 0 || length >= sizeof sender->host) {
        return false;
    }
    memcpy(sender->host, address, length);
    memcpy(sender->port, colon + 1, strlen(colon + 1) + 1);
    return true;
}

TevSender *tev_new(Session *session, const char *address, const char *name, char *message,
                   size_t message_size)
{
    TevSender *sender = mem_alloc_zeroed(1, sizeof *sender);
    if (!sender || !take_address(sender, address)) {
        snprintf(message, message_size,
                 sender ? "`--tev` takes HOST:PORT, as in " TEV_ADDRESS : "not enough memory");
        mem_free(sender);
        return NULL;
    }
    sender->session = session;
    sender->name = name;
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    bool started = pthread_create(&sender->thread, NULL, send_pictures, sender) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (!started) {
        snprintf(message, message_size, "no thread can be started");
        mem_free(sender);
        return NULL;
    }
    return sender;
}

void tev_free(TevSender *sender)
{
    if (sender) {
        session_close(sender->session);
        pthread_join(sender->thread, NULL);
        mem_free(sender);
    }
}
