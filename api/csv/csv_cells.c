#include "api/csv/csv_cells.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { CELL_BYTES = 48 };

static int is_blank(char c) { return c == ' ' || c == '\t'; }

static int is_digit(char c) { return c >= '0' && c <= '9'; }

/* Returns the end of a line: its CR or LF, or the end of the text. */
static const char *line_end(const char *line) { return line + strcspn(line, "\r\n"); }

const char *api_csv_line_next(const char *line) {
    const char *end = line_end(line);
    return end + (end[0] == '\r' && end[1] == '\n' ? 2 : *end != 0);
}

static struct api_csv_cell trimmed(const char *from, const char *end) {
    while (from < end && (is_blank(*from) || *from == '"')) from++;
    while (end > from && (is_blank(end[-1]) || end[-1] == '"')) end--;
    return (struct api_csv_cell){from, (int)(end - from)};
}

static const char *cell_end(const char *at, const char *end, char separator) {
    for (int quoted = 0; at < end; at++) {
        if (*at == '"') quoted = !quoted;
        if (quoted) continue;
        if (*at == separator || (separator == ' ' && *at == '\t')) break;
    }
    return at;
}

int api_csv_cut(const char *line, char separator, struct api_csv_cell cell[API_CSV_COLUMNS]) {
    const char *end = line_end(line), *at = line;
    int count = 0, blanks = separator == ' ';
    while (blanks && end > at && is_blank(end[-1])) end--;
    for (;;) {
        while (blanks && at < end && is_blank(*at)) at++;
        const char *stop = cell_end(at, end, separator);
        if (count < API_CSV_COLUMNS) cell[count] = trimmed(at, stop);
        count++;
        if (stop == end) return count;
        at = stop + 1;
    }
}

/* --- numbers --- */

/* returns the length of a multi-byte sign or blank, or 0; plain: its ASCII form */
static int odd_character(const char *at, int left, char *plain) {
    static const struct {
        const char *text;
        char plain; /* 0 = dropped */
    } odd[] = {
        {"\342\210\222", '-'}, {"\302\240", 0}, {"\342\200\257", 0}, {"\342\200\211", 0}, {"'", 0}};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        int bytes = (int)strlen(odd[i].text);
        if (bytes > left || memcmp(at, odd[i].text, (size_t)bytes) != 0) continue;
        *plain = odd[i].plain;
        return bytes;
    }
    return 0;
}

/* copies the text of a cell in ASCII, without blanks or apostrophes between thousands; returns 0 if
 * it is too long */
static int cell_plain(const struct api_csv_cell *cell, char out[CELL_BYTES]) {
    int length = 0;
    if (cell->bytes >= CELL_BYTES) return 0;
    for (int i = 0; i < cell->bytes;) {
        char plain = 0;
        int bytes = odd_character(cell->at + i, cell->bytes - i, &plain);
        if (!bytes) plain = cell->at[i];
        if (plain) out[length++] = plain;
        i += bytes ? bytes : 1;
    }
    out[length] = 0;
    return 1;
}

/* true if every thousands mark has a digit before it and exactly three digits after it */
static int is_grouped(const char *text, char mark) {
    const char *at = text + (*text == '-' || *text == '+');
    if (!is_digit(*at)) return 0;
    for (at = strchr(text, mark); at; at = strchr(at + 1, mark))
        if (!is_digit(at[1]) || !is_digit(at[2]) || !is_digit(at[3]) || is_digit(at[4])) return 0;
    return 1;
}

static void drop(char *text, char mark) {
    char *to = text;
    for (const char *from = text; *from; from++)
        if (*from != mark) *to++ = *from;
    *to = 0;
}

/* reads a number with this decimal mark; returns 0 if the text is not a number */
static int text_number(char *text, int comma, double *x) {
    char decimal = comma ? ',' : '.', thousands = comma ? '.' : ',';
    if (strchr(text, thousands)) {
        // a number with a point, such as "1.5", may also occur in a table with decimal commas
        if (!is_grouped(text, thousands))
            decimal = thousands;
        else
            drop(text, thousands);
    }
    char *mark = strchr(text, decimal), *end;
    if (mark) *mark = '.';
    if (text[strspn(text, "+-.0123456789eE")]) return 0;
    *x = strtod(text, &end);
    return end > text && !*end && isfinite(*x);
}

static int is_missing(const char *text) {
    static const char *const words[] = {"nan", "na", "n/a", "#n/a", "null", "none", "-",
                                        "--",  "?",  ".",   "inf",  "-nan", "nil"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strcasecmp(text, words[i])) return 1;
    return !*text;
}

/* --- clocks --- */

/* converts a date to days since 1970-01-01 (H. Hinnant, "chrono-compatible low-level date
 * algorithms") */
static double days_of(int year, int month, int day) {
    year -= month <= 2;
    int era = (year >= 0 ? year : year - 399) / 400;
    int of_era = year - era * 400;
    int of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
    return era * 146097.0 + of_era * 365.0 + of_era / 4 - of_era / 100 + of_year - 719468.0;
}

/* reads a date in front of a time, "2026-11-27" or "27.11.2026"; returns the text after it, NULL if
 * there is no date */
static const char *date_read(const char *text, double *days) {
    int part[3];
    const char *at = text;
    for (int i = 0; i < 3; i++) {
        char *end;
        if (!is_digit(*at)) return NULL;
        part[i] = (int)strtol(at, &end, 10);
        if (end - at > 4) return NULL;
        at = end;
        if (i < 2 && !strchr("-./", *at++)) return NULL;
    }
    int first = part[0] > 31, year = first ? part[0] : part[2], day = first ? part[2] : part[0];
    if (part[1] < 1 || part[1] > 12 || day < 1 || day > 31 || year < 1000) return NULL;
    *days = days_of(year, part[1], day);
    return *at == 'T' || *at == ' ' ? at + 1 : NULL;
}

/* reads "[date ]h:m[:s]" or "m:s.f"; returns 0 for any other text */
static int clock_read(char *text, double *x) {
    double days = 0, part[3];
    const char *at = date_read(text, &days);
    int count = 0;
    char *comma = strchr(text, ',');
    if (comma) *comma = '.';
    if (!at) at = text;
    for (; count < 3; count++) {
        char *end;
        if (!is_digit(*at)) return 0;
        part[count] = strtod(at, &end);
        at = end;
        if (*at != ':') break;
        at++;
    }
    if (*at == 'Z') at++;
    if (*at || count < 1 || count > 2) return 0;
    // two numbers are hours and minutes, but minutes and seconds if the second has a fraction
    int minutes = count == 1 && part[1] != floor(part[1]);
    *x = days * 86400 + (minutes ? part[0] * 60 + part[1] : part[0] * 3600 + part[1] * 60);
    if (count == 2) *x += part[2];
    return 1;
}

enum api_csv_kind api_csv_read(const struct api_csv_cell *cell, int comma, double *x) {
    char text[CELL_BYTES], copy[CELL_BYTES];
    if (!cell_plain(cell, text)) return API_CSV_WORD;
    memcpy(copy, text, sizeof copy);
    if (is_missing(text)) return API_CSV_EMPTY;
    if (text_number(text, comma, x)) return API_CSV_NUMBER;
    return clock_read(copy, x) ? API_CSV_CLOCK : API_CSV_WORD;
}

int api_csv_mark(const struct api_csv_cell *cell) {
    char text[CELL_BYTES];
    if (!cell_plain(cell, text) || text[strspn(text, "+-.,0123456789eE")]) return 0;
    const char *comma = strrchr(text, ','), *point = strrchr(text, '.');
    if (comma && point) return comma > point ? 1 : -1;
    if (!comma && !point) return 0;
    // "1,234" may be one thousand or a fraction; "0,234" must be a fraction
    if (is_grouped(text, comma ? ',' : '.') && fabs(strtod(text, NULL)) >= 1) return 0;
    return comma ? 1 : -1;
}

/* --- names --- */

enum { NAME_BYTES = 128 };

/* one degree in rad */
#define DEGREE (3.14159265358979323846 / 180)

/* words in names of columns, separated by blanks: English, German, French, Spanish, Dutch, Turkish,
 * Italian, Portuguese, Polish, Swedish, Russian, Chinese; all in lower case */
static const struct {
    enum api_csv_word word;
    const char *list;
} words[] = {
    {API_CSV_WORD_TIME,
     " t time zeit temps tiempo tijd zaman tempo czas tid aika čas время 时间 時間 زمن "
     "seconds timestamp elapsed zeitpunkt instant "},
    {API_CSV_WORD_ANGLE, " theta θ th thetas angle winkel auslenkung angulo ángulo hoek açı aci "
                         "angolo ângulo kąt kat vinkel "
                         "угол 角度 alpha α beta β deflection orientation encoder "},
    {API_CSV_WORD_JOINT, " joint relative elbow gelenk "},
    {API_CSV_WORD_AMPLITUDE, " amplitude amplitud genlik ampiezza amplituda амплитуда 振幅 "},
    {API_CSV_WORD_PERIOD, " period periode periodendauer schwingungsdauer période periodo "
                          "período periyot okres период 周期 "},
    {API_CSV_WORD_ALONG, " along radial "},
    {API_CSV_WORD_ACROSS, " across tangential "},
    {API_CSV_WORD_CART, " cart wagen chariot carrito carrello wózek araba тележка "},
    {API_CSV_WORD_PHI, " phi φ ϕ "},
    {API_CSV_WORD_X, " x xpos posx abscisse "},
    {API_CSV_WORD_Y, " y ypos posy ordonnee ordonnée "},
    {API_CSV_WORD_RATE,
     " omega ω thetad thetadot dtheta dθ phid angvel gyro gyroscope gyroskop winkelgeschwindigkeit "
     "hoeksnelheid "},
    {API_CSV_WORD_SPEED, " velocity speed rate vitesse velocidad snelheid hız hızı hiz hizi "
                         "velocità velocita velocidade geschwindigkeit "
                         "prędkość hastighet скорость 速度 v vx vy dot "},
    {API_CSV_WORD_ERROR, " error err errors sigma σ uncertainty unc std stdev stderr sd fehler "
                         "unsicherheit erreur incertitude "
                         "error incertidumbre fout onzekerheid hata belirsizlik errore incertezza "
                         "erro incerteza błąd fel ошибка 误差 delta δ "},
    {API_CSV_WORD_MODEL, " sim simulated simulation simule simulé simulée simuliert simulado model "
                         "modell modele modèle modelo "
                         "fit fitted theory theorie théorie theoretical predicted prediction "
                         "calculated berechnet residual residuals "},
    {API_CSV_WORD_FRAME, " frame frames image img step index nr no number bild "},
    {API_CSV_WORD_OTHER, " r radius likelihood confidence score energy energie énergie mass masse "
                         "acceleration accel ax ay az a "
                         "beschleunigung ivme force kraft z length absolute "},
};

/* converts a two-byte UTF-8 capital to lower case in place: Latin, Greek, Cyrillic */
static void small_letter(unsigned char at[2]) {
    static const struct {
        unsigned char lead, from, to, small_lead, shift;
    } ranges[] = {{0xC3, 0x80, 0x9E, 0xC3, 0x20},
                  {0xCE, 0x91, 0x9F, 0xCE, 0x20},
                  {0xCE, 0xA0, 0xA9, 0xCF, 0xE0},
                  {0xD0, 0x90, 0x9F, 0xD0, 0x20},
                  {0xD0, 0xA0, 0xAF, 0xD1, 0xE0}};
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        if (at[0] != ranges[i].lead || at[1] < ranges[i].from || at[1] > ranges[i].to) continue;
        at[0] = ranges[i].small_lead, at[1] = (unsigned char)(at[1] + ranges[i].shift);
        return;
    }
}

static int text_of(const struct api_csv_cell *cell, char text[NAME_BYTES]) {
    int bytes = cell->bytes < NAME_BYTES ? cell->bytes : NAME_BYTES - 1;
    if (bytes) memcpy(text, cell->at, (size_t)bytes);
    text[bytes] = 0;
    for (int i = 0; i < bytes; i++) {
        unsigned char *at = (unsigned char *)text + i;
        if (*at >= 'A' && *at <= 'Z') *at += 32;
        if (*at >= 0xC3 && i + 1 < bytes) small_letter(at), i++;
    }
    return bytes;
}

/* --- units --- */

static const struct unit {
    const char *list;
    double s, rad, m, rad_s;
    int pixels;
} units[] = {{" s sec secs second seconds sekunden ", 1, 0, 0, 0, 0},
             {" ms ", 1e-3, 0, 0, 0, 0},
             {" us \302\265s \316\274s ", 1e-6, 0, 0, 0, 0},
             {" min ", 60, 0, 0, 0, 0},
             {" rad radians ", 0, 1, 0, 0, 0},
             {" deg degree degrees grad \302\260 ", 0, DEGREE, 0, 0, 0},
             {" m ", 0, 0, 1, 0, 0},
             {" cm ", 0, 0, 0.01, 0, 0},
             {" mm ", 0, 0, 0.001, 0, 0},
             {" rad/s 1/s ", 0, 0, 0, 1, 0},
             {" deg/s \302\260/s dps ", 0, 0, 0, DEGREE, 0},
             {" px pixel pixels ", 0, 0, 0, 0, 1},
             {" hz m/s m/s^2 m/s\302\262 n nm kg j ", 0, 0, 0, 0,
              0}}; // {0} = units of quantities that cannot be fitted

static const struct unit *unit_of(const char *text, int bytes) {
    char word[NAME_BYTES + 3] = " ";
    if (bytes < 1) return NULL;
    memcpy(word + 1, text, (size_t)bytes);
    word[bytes + 1] = ' ', word[bytes + 2] = 0;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strstr(units[i].list, word)) return &units[i];
    return NULL;
}

static void unit_put(struct api_csv_words *found, const char *text, int bytes) {
    const struct unit *unit = unit_of(text, bytes);
    if (unit) {
        found->s = unit->s, found->rad = unit->rad, found->m = unit->m;
        found->rad_s = unit->rad_s, found->pixels |= unit->pixels;
    }
    if (bytes > 2 && (!unit || !unit->rad_s) && memmem(text, (size_t)bytes, "/s", 2))
        found->words |= API_CSV_WORD_OTHER;
}

int api_csv_is_unit(const struct api_csv_cell *cell) {
    char text[NAME_BYTES];
    text_of(cell, text);
    const char *bare = text + strspn(text, "([");
    return unit_of(bare, (int)strcspn(bare, ")]")) != NULL;
}

/* removes "(deg)", "[s]", "/s", ", m" or " in s" from a name, and stores that unit */
static void unit_cut(struct api_csv_words *found, char *text) {
    char *open = strrchr(text, '('), *slash = strrchr(text, '/'), *in = strstr(text, " in ");
    if (!open) open = strrchr(text, '[');
    if (open) {
        size_t bytes = strcspn(open + 1, ")]");
        unit_put(found, open + 1, (int)bytes);
        // "Time (s) Run #1": text after the unit is ignored
        *open = 0;
    } else if (in) {
        unit_put(found, in + 4, (int)strlen(in + 4));
        *in = 0;
    } else if (slash && slash > text) {
        unit_put(found, slash + 1, (int)strlen(slash + 1));
        *slash = 0;
    }
}

/* --- words --- */

static int is_letter(char c) { return (c >= 'a' && c <= 'z') || (unsigned char)c >= 0x80; }

static void word_put(struct api_csv_words *found, const char *at, int bytes, int last) {
    char word[NAME_BYTES + 3] = " ";
    memcpy(word + 1, at, (size_t)bytes);
    word[bytes + 1] = ' ', word[bytes + 2] = 0;
    int before = found->words;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strstr(words[i].list, word)) found->words |= words[i].word;
    // "temps_s", "theta1_mesure_deg": a unit without brackets is the last word
    if (found->words == before && last && !found->s && !found->rad && !found->m && !found->rad_s)
        unit_put(found, at, bytes);
}

struct api_csv_words api_csv_words_of(const struct api_csv_cell *name,
                                      const struct api_csv_cell *unit) {
    struct api_csv_words found = {.number = -1};
    char text[NAME_BYTES];
    assert(name && unit);
    text_of(unit, text);
    const char *bare = text + strspn(text, "([ ");
    unit_put(&found, bare, (int)strcspn(bare, ")] "));
    text_of(name, text);
    if (text[0] && text[strlen(text) - 1] == '\'') found.words |= API_CSV_WORD_PRIME;
    unit_cut(&found, text);
    for (const char *at = text; *at;) {
        if (*at >= '0' && *at <= '9') {
            char *end;
            long number = strtol(at, &end, 10);
            found.number = number < 1000 ? (int)number : -1;
            at = end;
        } else if (is_letter(*at)) {
            const char *from = at;
            while (is_letter(*at)) at++;
            word_put(&found, from, (int)(at - from), !*at);
        } else {
            at++;
        }
    }
    return found;
}
