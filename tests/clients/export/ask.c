/* Prints what messages become: ask SCENE.carom, a message in each line of stdin. Of each the commands that it sends, in
   hexadecimal, or ! and the reason for which it is refused. "load 1" begins anew, "load 0" with the score. With a
   number of frames, it computes as many after each. */
#include <stdio.h>

#include "library.c"

int main(int count, char **words) {
    static char line[2 * LONGEST_MESSAGE];
    static float out[4096 * 8];
    FILE *file = fopen(words[1], "rb");
    if (!file) return 2;
    fseek(file, 0, SEEK_END);
    size_t size = (size_t)ftell(file);
    rewind(file);
    char *baked = malloc(size);
    if (!baked || fread(baked, 1, size, file) != size) return 2;
    fclose(file);
    carom *scene = carom_open(baked, size, 1);
    free(baked);
    if (!scene) return 1;
    long frames = count > 2 ? atol(words[2]) : 0;
    while (fgets(line, sizeof line, stdin)) {
        line[strcspn(line, "\n")] = 0;
        int64_t first = scene->inbox_written;
        if (!strncmp(line, "load ", 5)) {
            carom_load(scene, line[5] == '1');
            printf("\n");
        } else if (!carom_send(scene, line, -1.0)) {
            printf("!%s\n", carom_answer(scene));
        } else {
            for (; first < scene->inbox_written; first++) {
                for (int64_t n = 0; n < scene->command_size; n++)
                    printf("%02x", scene->inbox[first % scene->ring * scene->command_size + n]);
                printf(" ");
            }
            printf("\n");
        }
        if (frames)
            carom_process(scene, out, (size_t)frames);
        else
            scene->inbox_read = scene->inbox_written;
    }
    carom_close(scene);
    return 0;
}
