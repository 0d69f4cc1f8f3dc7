#include "api/csv/csv_words.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

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
              0}}; // units of quantities that cannot be fitted

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
