// Put it on the AudioListener: the scene that it plays, and the frames of Unity's physics.
using System.Collections.Generic;
using UnityEngine;

[RequireComponent(typeof(AudioListener))]
public sealed class CaromScene : MonoBehaviour
{
    public TextAsset scene; // scene.carom, renamed to scene.bytes
    [Range(0f, 1f)] public float share = 0.15f; // of a core that the sound may take

    readonly List<CaromBody> bodies = new List<CaromBody>();
    Carom.Scene played;
    float[] sound = new float[0];

    public Carom.Scene Played { get { return played; } }

    void Awake()
    {
        played = new Carom.Scene(scene.bytes);
        if (AudioSettings.outputSampleRate != (int)played.Rate)
            Debug.LogError("Carom: export with --rate " + AudioSettings.outputSampleRate);
        played.Govern(share);
    }

    public void Add(CaromBody body)
    {
        bodies.Add(body);
    }

    public void Remove(CaromBody body)
    {
        bodies.Remove(body);
    }

    // Contacts of a physics step are reported after FixedUpdate: the next one ends its frame.
    void FixedUpdate()
    {
        foreach (CaromBody body in bodies) body.Report();
        played.Listen(Of(transform.position), Of(transform.right));
        played.Frame(Time.fixedDeltaTime);
    }

    void OnAudioFilterRead(float[] data, int channels)
    {
        Carom.Scene now = played;
        if (now == null) return;
        int frames = data.Length / channels, own = now.Channels;
        if (sound.Length != frames * own) sound = new float[frames * own];
        now.Process(sound, frames);
        for (int n = 0; n < frames; n++)
            for (int c = 0; c < channels; c++) data[n * channels + c] += c < own ? sound[n * own + c] : 0f;
    }

    void OnDestroy()
    {
        Carom.Scene gone = played;
        played = null;
        gone.Dispose();
    }

    public static float[] Of(Vector3 vector)
    {
        return new[] { vector.x, vector.y, vector.z };
    }

    public static float[] Of(Quaternion turn)
    {
        return new[] { turn.w, turn.x, turn.y, turn.z };
    }
}
